#include "link/kind_order.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::uint64_t kSender = 7;

struct Stream {
  SequenceTracker tracker;
  KindOrder order;

  Arrival arrive(const Message& message, std::uint64_t sequence, std::uint64_t sender = kSender) {
    const Arrival arrival = tracker.track(sender, sequence);
    EXPECT_TRUE(arrival == Arrival::newest || arrival == Arrival::reordered);
    return order.note(tracker, arrival, message, sequence);
  }
};

TEST(KindOrder, WhatAnotherKindOvertookIsNew) {
  Stream stream;
  EXPECT_EQ(stream.arrive(ForceCommand{}, 1), Arrival::newest);
  EXPECT_EQ(stream.arrive(ForceCommand{}, 4), Arrival::newest);
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 2), Arrival::newest);
  EXPECT_EQ(stream.arrive(ForceCommand{}, 3), Arrival::reordered);
}

TEST(KindOrder, OfAKindTheNewestWins) {
  Stream stream;
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 5), Arrival::newest);
  EXPECT_EQ(stream.arrive(ForceCommand{}, 9), Arrival::newest);
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 3), Arrival::reordered);
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 7), Arrival::newest) << "overtaken by a force alone";
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 6), Arrival::reordered);
}

TEST(KindOrder, NumbersAreComparedAroundTheCircle) {
  Stream stream;
  const std::uint64_t last = ~std::uint64_t{0};
  EXPECT_EQ(stream.arrive(HapticsSetup{}, last - 1), Arrival::newest);
  EXPECT_EQ(stream.arrive(ForceCommand{}, 2), Arrival::newest);
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 1), Arrival::newest);
  EXPECT_EQ(stream.arrive(HapticsSetup{}, last), Arrival::reordered);
}

TEST(KindOrder, ANewProcessAndAJumpBeginAgain) {
  Stream stream;
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 1000), Arrival::newest);
  EXPECT_EQ(stream.arrive(ForceCommand{}, 10, kSender + 1), Arrival::newest);
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 9, kSender + 1), Arrival::newest) << "1000 was another process's";
  EXPECT_EQ(stream.arrive(ForceCommand{}, 10 + 2 * SequenceTracker::kMaxGap, kSender + 1), Arrival::newest);
  EXPECT_EQ(stream.tracker.counts().jumps, 1U);
  EXPECT_EQ(stream.arrive(ForceCommand{}, 11, kSender + 1), Arrival::newest) << "another jump, back";
  EXPECT_EQ(stream.arrive(HapticsSetup{}, 12, kSender + 1), Arrival::newest);
}

}  // namespace
}  // namespace hapton
