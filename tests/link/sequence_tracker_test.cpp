#include "link/sequence_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <vector>

namespace hapton {
namespace {

constexpr std::uint64_t kSender = 42;

TEST(SequenceTrackerTest, AnUnbrokenSequenceHasNoLoss) {
  SequenceTracker tracker;
  for (std::uint64_t n = 1; n <= 5000; ++n) {
    EXPECT_EQ(tracker.track(kSender, n), Arrival::newest);
  }
  EXPECT_EQ(tracker.counts().received, 5000U);
  EXPECT_EQ(tracker.counts().lost, 0U);
  EXPECT_EQ(tracker.newest(), 5000U);
}

TEST(SequenceTrackerTest, CountsGapsAndTakesThemBackWhenFilled) {
  SequenceTracker tracker;
  tracker.track(kSender, 1);
  EXPECT_EQ(tracker.track(kSender, 5), Arrival::newest);
  EXPECT_EQ(tracker.counts().lost, 3U);
  EXPECT_EQ(tracker.track(kSender, 3), Arrival::reordered);
  EXPECT_EQ(tracker.counts().lost, 2U);
  EXPECT_EQ(tracker.track(kSender, 3), Arrival::duplicate);
  EXPECT_EQ(tracker.counts().lost, 2U);
  EXPECT_EQ(tracker.track(kSender, 5), Arrival::duplicate);
  EXPECT_EQ(tracker.counts().reordered, 1U);
  EXPECT_EQ(tracker.counts().duplicate, 2U);
}

TEST(SequenceTrackerTest, ANumberBeforeTheFirstFillsNoGap) {
  SequenceTracker tracker;
  tracker.track(kSender, 10);
  tracker.track(kSender, 12);
  EXPECT_EQ(tracker.counts().lost, 1U);
  EXPECT_EQ(tracker.track(kSender, 9), Arrival::reordered);
  EXPECT_EQ(tracker.counts().lost, 1U);
}

TEST(SequenceTrackerTest, ARestartedSenderStartsAfreshAndItsOldDatagramsAreStale) {
  SequenceTracker tracker;
  tracker.track(kSender, 100);
  EXPECT_EQ(tracker.track(kSender + 1, 1), Arrival::newest);
  EXPECT_EQ(tracker.track(kSender, 101), Arrival::stale);
  EXPECT_EQ(tracker.track(kSender + 1, 2), Arrival::newest);
  EXPECT_EQ(tracker.counts().restarts, 1U);
  EXPECT_EQ(tracker.counts().stale, 1U);
  EXPECT_EQ(tracker.counts().lost, 0U);
}

TEST(SequenceTrackerTest, HugeJumpsAreNoLoss) {
  for (const std::uint64_t jump :
       {SequenceTracker::kMaxGap + 1, std::uint64_t{1} << 63, std::numeric_limits<std::uint64_t>::max() - 5'000'000}) {
    SequenceTracker tracker;
    tracker.track(kSender, 1000);
    EXPECT_EQ(tracker.track(kSender, 1000 + jump), Arrival::newest);
    EXPECT_EQ(tracker.counts().jumps, 1U);
    EXPECT_EQ(tracker.counts().lost, 0U);
    EXPECT_EQ(tracker.track(kSender, 1001 + jump), Arrival::newest);
    EXPECT_EQ(tracker.counts().lost, 0U);
  }
}

TEST(SequenceTrackerTest, WrapsAround) {
  SequenceTracker tracker;
  const std::uint64_t last = std::numeric_limits<std::uint64_t>::max();
  tracker.track(kSender, last - 1);
  EXPECT_EQ(tracker.track(kSender, last), Arrival::newest);
  EXPECT_EQ(tracker.track(kSender, 1), Arrival::newest);
  EXPECT_EQ(tracker.counts().lost, 1U);
  EXPECT_EQ(tracker.track(kSender, 0), Arrival::reordered);
  EXPECT_EQ(tracker.counts().lost, 0U);
  EXPECT_EQ(tracker.counts().jumps, 0U);
}

TEST(SequenceTrackerTest, WhatIsSkippedAcrossTheWrapIsStillAwaited) {
  SequenceTracker tracker;
  for (std::uint64_t before = 2000; before > 2; --before) tracker.track(kSender, 0 - before);
  EXPECT_EQ(tracker.track(kSender, 2), Arrival::newest);
  EXPECT_EQ(tracker.counts().lost, 4U);
  for (const std::uint64_t late : {std::uint64_t{0} - 2, std::uint64_t{0} - 1, std::uint64_t{0}, std::uint64_t{1}}) {
    EXPECT_EQ(tracker.track(kSender, late), Arrival::reordered) << late;
  }
  EXPECT_EQ(tracker.counts().lost, 0U);
}

TEST(SequenceTrackerTest, ANumberTooOldToCheckCountsAsADuplicate) {
  SequenceTracker tracker;
  tracker.track(kSender, 1);
  tracker.track(kSender, 2 + SequenceTracker::kWindow);
  EXPECT_EQ(tracker.track(kSender, 2), Arrival::duplicate);
  EXPECT_EQ(tracker.track(kSender, 3), Arrival::reordered);
}

// The brute-force twin: a set of all numbers received.
TEST(SequenceTrackerTest, AgreesWithASetOnARandomLink) {
  constexpr std::uint64_t kSeed = 7;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::vector<std::pair<double, std::uint64_t>> arrivals;
  for (std::uint64_t n = 1; n <= 20'000; ++n) {
    const int copies = random() % 10 == 0 ? 0 : random() % 20 == 0 ? 2 : 1;
    for (int copy = 0; copy < copies; ++copy) {
      arrivals.emplace_back(static_cast<double>(n) + static_cast<double>(random() % 400), n);
    }
  }
  std::stable_sort(arrivals.begin(), arrivals.end(), [](const auto& a, const auto& b) { return a.first < b.first; });

  SequenceTracker tracker;
  std::set<std::uint64_t> received;
  SequenceCounts expected;
  const std::uint64_t first = arrivals.front().second;
  std::uint64_t newest = 0;
  for (const auto& [time, n] : arrivals) {
    ++expected.received;
    const bool is_new = received.insert(n).second;
    const Arrival arrival = !is_new ? Arrival::duplicate : n > newest ? Arrival::newest : Arrival::reordered;
    expected.duplicate += arrival == Arrival::duplicate ? 1 : 0;
    expected.reordered += arrival == Arrival::reordered ? 1 : 0;
    newest = std::max(newest, n);
    ASSERT_EQ(tracker.track(kSender, n), arrival) << n;
  }
  const auto after_first = static_cast<std::uint64_t>(std::distance(received.lower_bound(first), received.end()));
  EXPECT_EQ(tracker.counts().lost, newest - first + 1 - after_first);
  EXPECT_EQ(tracker.counts().duplicate, expected.duplicate);
  EXPECT_EQ(tracker.counts().reordered, expected.reordered);
  EXPECT_EQ(tracker.counts().received, expected.received);
}

TEST(SequenceTrackerTest, ARejoiningPeerMayRestartItsNumbers) {
  SequenceTracker tracker;
  for (std::uint64_t sequence = 1; sequence <= 3000; ++sequence) tracker.track(7, sequence);
  EXPECT_EQ(tracker.track(7, 5), Arrival::duplicate);
  EXPECT_EQ(tracker.track(7, 6, true), Arrival::newest);
  EXPECT_EQ(tracker.track(7, 7), Arrival::newest);
  // A number ahead of the newest counts as usual: the numbers between them were lost.
  EXPECT_EQ(tracker.track(7, 10, true), Arrival::newest);
  EXPECT_EQ(tracker.counts().lost, 2U);
}

}  // namespace
}  // namespace hapton
