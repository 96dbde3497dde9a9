#include "io_node/response_tracker.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

using Verdict = ResponseTracker::Verdict;

ForceCommand force_for(std::uint64_t sample, std::uint32_t skipped = 0) {
  ForceCommand command;
  command.echo_sample = sample;
  command.echo_sample_time_ns = static_cast<std::int64_t>(sample) * kMs;
  command.skipped_samples = skipped;
  return command;
}

struct ResponseTrackerTest : testing::Test {
  std::unique_ptr<ResponseTracker> tracker = std::make_unique<ResponseTracker>();
  void take(std::uint64_t from, std::uint64_t last, bool is_expected = true) {
    for (std::uint64_t s = from; s <= last; ++s) tracker->take(s, static_cast<std::int64_t>(s) * kMs, is_expected);
  }
  void take_or_withhold(std::uint64_t sample, unsigned which) {
    if (which == 0) return tracker->withhold(sample, static_cast<std::int64_t>(sample) * kMs);
    take(sample, sample, which > 2);
  }
};

TEST_F(ResponseTrackerTest, DistinguishesInTimeLateReorderedDuplicateAndUnknown) {
  EXPECT_EQ(tracker->reply(force_for(0)), Verdict::unknown);
  take(1, 1);
  EXPECT_FALSE(tracker->has_newest_reply());
  EXPECT_EQ(tracker->reply(force_for(1)), Verdict::in_time);
  EXPECT_TRUE(tracker->has_newest_reply());
  EXPECT_EQ(tracker->reply(force_for(1)), Verdict::duplicate);
  take(2, 5);
  EXPECT_EQ(tracker->reply(force_for(4)), Verdict::late);
  EXPECT_EQ(tracker->reply(force_for(3)), Verdict::reordered);
  EXPECT_EQ(tracker->reply(force_for(6)), Verdict::unknown);
  ForceCommand forged = force_for(5);
  forged.echo_sample_time_ns += 1;
  EXPECT_EQ(tracker->reply(forged), Verdict::unknown);
  EXPECT_EQ(tracker->reply(force_for(~std::uint64_t{0})), Verdict::unknown);
}

TEST_F(ResponseTrackerTest, AnOvertakenSampleIsLostAfterTheReplyTimeout) {
  take(1, 10);
  tracker->reply(force_for(5));
  tracker->settle(ResponseTracker::kReplyTimeoutNs);
  EXPECT_EQ(tracker->counts().lost, 0U);
  tracker->settle(ResponseTracker::kReplyTimeoutNs + 100 * kMs);
  EXPECT_EQ(tracker->counts().lost, 4U);  // 6 to 10 still wait: no newer sample has a reply
  EXPECT_EQ(tracker->reply(force_for(3)), Verdict::reordered);
  EXPECT_EQ(tracker->counts().lost, 3U);
}

TEST_F(ResponseTrackerTest, SkippedIsSupersededNotLost) {
  take(1, 10);
  tracker->reply(force_for(2));
  tracker->reply(force_for(9, 4));
  EXPECT_EQ(tracker->counts().superseded, 4U);  // 5 to 8
  tracker->close(true);
  EXPECT_EQ(tracker->counts().lost, 4U);  // 1, 3, 4 and 10
}

TEST_F(ResponseTrackerTest, AFalseNumberOfSkippedSamplesSupersedesNoMoreThanThereAre) {
  take(1, 10);
  tracker->reply(force_for(9, ~std::uint32_t{0}));
  EXPECT_EQ(tracker->counts().superseded, 8U);
  tracker->reply(force_for(10, ~std::uint32_t{0}));
  EXPECT_EQ(tracker->counts().superseded, 8U);
}

// 1 has a reply. 2 and 5 are sent; 3 and 4 are not, because a newer one was there. The node skips 2 and 5 and replies to 6.
TEST_F(ResponseTrackerTest, SamplesThatWereNeverSentDoNotCountAsSkipped) {
  take(1, 1);
  tracker->reply(force_for(1));
  take(2, 2);
  tracker->withhold(3, 3 * kMs);
  tracker->withhold(4, 4 * kMs);
  take(5, 6);
  tracker->reply(force_for(6, 2));
  tracker->close(true);
  EXPECT_EQ(tracker->counts().superseded, 2U);
  EXPECT_EQ(tracker->counts().excused, 2U);
  EXPECT_EQ(tracker->counts().lost, 0U);
  EXPECT_EQ(tracker->counts().taken, 6U);
}

// The cycles in between were never reported. Their slots are unused in the first run and hold old samples in the second one.
TEST_F(ResponseTrackerTest, NumbersOfCyclesThatWereNotReportedDoNotCountAsSkipped) {
  for (const std::uint64_t samples_before : {std::uint64_t{3}, 2 * ResponseTracker::kCapacity}) {
    tracker = std::make_unique<ResponseTracker>();
    for (std::uint64_t s = 1; s <= samples_before; ++s) {
      take(s, s);
      tracker->reply(force_for(s));
    }
    take(samples_before + 1, samples_before + 1);
    take(samples_before + 40, samples_before + 41);
    tracker->reply(force_for(samples_before + 41, 2));
    tracker->settle(static_cast<std::int64_t>(samples_before) * kMs + 10 * ResponseTracker::kReplyTimeoutNs);
    EXPECT_EQ(tracker->counts().superseded, 2U) << samples_before;
    EXPECT_EQ(tracker->counts().lost, 0U) << samples_before;
    EXPECT_EQ(tracker->counts().taken, samples_before + 3) << samples_before;
  }
}

// A node that falls behind replies to the newest of its waiting samples; a hub that falls behind sends the newest of its own.
// If the node replies to all samples that it did not skip, none is lost.
TEST_F(ResponseTrackerTest, ANodeThatSaysWhatItSkippedHasLostNothing) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    tracker = std::make_unique<ResponseTracker>();
    std::vector<std::uint64_t> unanswered;
    std::uint64_t newest = 0;
    for (int n = 0; n < 30'000; ++n) {
      for (std::uint64_t behind = random() % 8; behind < 2; ++behind)
        ++newest, tracker->withhold(newest, static_cast<std::int64_t>(newest) * kMs);
      if (random() % 50 == 0) newest += random() % 30;
      ++newest;
      take(newest, newest);
      unanswered.push_back(newest);
      if (random() % 3 == 0) continue;
      tracker->reply(force_for(newest, static_cast<std::uint32_t>(unanswered.size() - 1)));
      unanswered.clear();
      tracker->settle(static_cast<std::int64_t>(newest) * kMs);
    }
    tracker->close(false);
    ASSERT_EQ(tracker->counts().lost, 0U) << seed;
    ASSERT_GT(tracker->counts().superseded, 0U);
  }
}

TEST_F(ResponseTrackerTest, SamplesWithoutAHapticsNodeAreExcused) {
  take(1, 10, false);
  take(11, 20);
  tracker->reply(force_for(12));
  tracker->excuse_waiting();
  EXPECT_EQ(tracker->counts().lost, 1U);  // 11: a newer sample has a reply
  EXPECT_EQ(tracker->counts().excused, 18U);
  EXPECT_EQ(tracker->reply(force_for(5)), Verdict::reordered);
  EXPECT_EQ(tracker->counts().excused, 17U);
}

// In all cases, every sample is in one category only.
TEST_F(ResponseTrackerTest, CountsAlwaysAddUp) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    std::mt19937_64 random(seed);
    tracker = std::make_unique<ResponseTracker>();
    std::uint64_t newest = 0;
    for (int n = 0; n < 60'000; ++n) {
      const auto action = random() % 100;
      if (action < 60)
        take_or_withhold(++newest, static_cast<unsigned>(random() % 20));
      else if (action < 97)
        tracker->reply(force_for(newest - std::min(newest, random() % 30), static_cast<std::uint32_t>(random() % 4)));
      else if (action < 98)
        tracker->reply(force_for(random() % (newest + 10), static_cast<std::uint32_t>(random())));
      else if (action < 99)
        tracker->settle(static_cast<std::int64_t>(newest) * kMs);
      else if (random() % 50 == 0)
        tracker->excuse_waiting();
    }
    tracker->close(seed % 2 == 0);
    const auto& c = tracker->counts();
    ASSERT_EQ(c.taken, c.in_time + c.late + c.reordered + c.superseded + c.lost + c.excused) << seed;
    ASSERT_GT(c.lost, 0U);
  }
}

// The device side alone has counted in between. A tracker that visits each of these numbers would take days.
TEST_F(ResponseTrackerTest, AJumpOfTheNumbersCostsNoTime) {
  constexpr std::uint64_t kFar = 1'000'000'000'000'000;
  take(1, 1);
  tracker->reply(force_for(1));
  take(kFar, kFar + 2);
  EXPECT_EQ(tracker->reply(force_for(kFar + 1)), Verdict::late);
  tracker->close(true);
  EXPECT_EQ(tracker->counts().taken, 4U);
  EXPECT_EQ(tracker->counts().in_time, 1U);
  EXPECT_EQ(tracker->counts().lost, 2U);
  EXPECT_EQ(tracker->counts().excused, 0U);
}

// The same samples count as lost or excused: those that a newer reply overtook are lost, the others only if the node is alive.
TEST_F(ResponseTrackerTest, AtTheEndOnlyALivingNodeHasLostWhatWaits) {
  for (const bool is_alive : {true, false}) {
    tracker = std::make_unique<ResponseTracker>();
    take(1, 10);
    tracker->reply(force_for(4));
    tracker->close(is_alive);
    EXPECT_EQ(tracker->counts().lost, is_alive ? 9U : 3U);
    EXPECT_EQ(tracker->counts().excused, is_alive ? 0U : 6U);
  }
}

// A sample is lost when its own time is more than kReplyTimeoutNs ago.
TEST_F(ResponseTrackerTest, TheReplyTimeoutIsForEachSample) {
  take(1, 4);
  tracker->reply(force_for(4));
  tracker->settle(ResponseTracker::kReplyTimeoutNs + 2 * kMs);
  EXPECT_EQ(tracker->counts().lost, 1U);
  tracker->settle(ResponseTracker::kReplyTimeoutNs + 2 * kMs + 1);
  EXPECT_EQ(tracker->counts().lost, 2U);
  EXPECT_EQ(tracker->counts().late + tracker->counts().in_time, 1U);
}

TEST_F(ResponseTrackerTest, ForgetsWhatIsOlderThanItsCapacity) {
  take(1, 3 * ResponseTracker::kCapacity);
  EXPECT_EQ(tracker->reply(force_for(1)), Verdict::unknown);
  EXPECT_EQ(tracker->reply(force_for(2 * ResponseTracker::kCapacity)), Verdict::unknown);
  EXPECT_EQ(tracker->reply(force_for(2 * ResponseTracker::kCapacity + 1)), Verdict::late);
  EXPECT_EQ(tracker->counts().excused, 2 * ResponseTracker::kCapacity);
}

}  // namespace
}  // namespace hapton
