#include "link/rejection_monitor.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

#include "link/memory_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

const Address kOne = memory_address(66, 6);
const Address kOther = memory_address(67, 6);

void note(RejectionMonitor& watch, Rejection rejection, const Address& from, int count) {
  for (int i = 0; i < count; ++i) watch.note(rejection, from);
}

TEST(RejectionMonitorTest, SaysNothingOfAFew) {
  RejectionMonitor watch;
  EXPECT_FALSE(watch.take(kSecond));
  note(watch, Rejection::wrong_key, kOne, 900);
  EXPECT_FALSE(watch.take(2 * kSecond));
  note(watch, Rejection::replayed_handshake, kOne, 20);  // two nodes of one host that send requests at the same time
  EXPECT_FALSE(watch.take(3 * kSecond));
}

// Our nodes repeat no handshake: a peer that repeats a hundred a second is reported, although of other kinds a thousand would pass.
TEST(RejectionMonitorTest, NamesASlowFloodOfHandshakes) {
  for (const Rejection rejection : {Rejection::replayed_handshake, Rejection::too_many_handshakes}) {
    RejectionMonitor watch;
    watch.take(kSecond);
    note(watch, rejection, kOne, 100);
    note(watch, Rejection::unknown_session, kOther, 900);
    const auto flood = watch.take(2 * kSecond);
    ASSERT_TRUE(flood);
    EXPECT_EQ(flood->rejection, rejection);
    EXPECT_EQ(flood->from, kOne);
  }
}

TEST(RejectionMonitorTest, TakesMoreThanOneAtATime) {
  RejectionMonitor watch;
  watch.take(kSecond);
  watch.note(Rejection::oversized, kOne, 700'000);
  const auto flood = watch.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::oversized);
  EXPECT_DOUBLE_EQ(flood->per_second, 700'000.0);
}

TEST(RejectionMonitorTest, NamesAFloodOnceASecondAndTheWorstAlone) {
  RejectionMonitor watch;
  watch.take(kSecond);
  note(watch, Rejection::malformed, kOther, 2000);
  note(watch, Rejection::replayed_handshake, kOne, 50'000);
  EXPECT_FALSE(watch.take(kSecond + kSecond / 2));
  const auto flood = watch.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::replayed_handshake);
  EXPECT_EQ(flood->from, kOne);
  EXPECT_FALSE(flood->is_from_several);
  EXPECT_DOUBLE_EQ(flood->per_second, 50'000.0);
  EXPECT_FALSE(watch.take(2 * kSecond));
  EXPECT_FALSE(watch.take(3 * kSecond)) << "it is over";
}

// A filter in the kernel drops most of a flood unseen and lets a random few through.
TEST(RejectionMonitorTest, WhatWasKeptOutCountsForEachKindInItsShare) {
  RejectionMonitor watch;
  watch.take(kSecond);
  note(watch, Rejection::malformed, kOne, 300);
  note(watch, Rejection::unknown_session, kOther, 100);
  watch.note_filtered(99'600);
  const auto flood = watch.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->rejection, Rejection::malformed);
  EXPECT_NEAR(flood->per_second, 75'000.0, 1e-6);
  EXPECT_TRUE(flood->is_mostly_filtered);
  watch.note_filtered(1000);
  EXPECT_FALSE(watch.take(3 * kSecond)) << "nobody knows what of";
  note(watch, Rejection::malformed, kOne, 5000);
  const auto next = watch.take(4 * kSecond);
  ASSERT_TRUE(next);
  EXPECT_NEAR(next->per_second, 5000.0, 1e-6);
  EXPECT_FALSE(next->is_mostly_filtered);
}

TEST(RejectionMonitorTest, ARateIsOfTheTimeThatPassed) {
  RejectionMonitor watch;
  watch.take(0);
  note(watch, Rejection::forged, kOne, 5000);
  EXPECT_FALSE(watch.take(10 * kSecond));
}

TEST(RejectionMonitorTest, SaysWhenThereAreSeveralSources) {
  RejectionMonitor watch;
  watch.take(kSecond);
  note(watch, Rejection::forged, kOne, 1);
  note(watch, Rejection::forged, kOther, 5000);
  const auto flood = watch.take(2 * kSecond);
  ASSERT_TRUE(flood);
  EXPECT_EQ(flood->from, kOther);
  EXPECT_TRUE(flood->is_from_several);
}

TEST(RejectionMonitorTest, EveryRejectionHasItsOwnText) {
  std::set<std::string_view> words;
  for (std::size_t n = 0; n < kRejections; ++n) words.insert(describe(static_cast<Rejection>(n)));
  EXPECT_EQ(words.size(), kRejections);
}

}  // namespace
}  // namespace hapton
