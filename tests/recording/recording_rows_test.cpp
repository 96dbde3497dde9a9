#include "recording/recording_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "tests/recording/opened_recording.h"

namespace hapton {
namespace {

// The newest sample until t_s, found by a search through all rows.
std::uint64_t brute_force_sample(const std::vector<CycleRow>& all_rows, double t_s) {
  std::uint64_t newest = all_rows.front().sample;
  for (const CycleRow& row : all_rows) {
    if (row.sample_t_s <= t_s) newest = row.sample;
  }
  return newest;
}

std::vector<CycleRow> read_all(const std::filesystem::path& file) {
  std::vector<CycleRow> all_rows;
  auto reader = SessionReader::open(file);
  CycleTable(kCyclesStartNs, [&](const CycleRow& row) { all_rows.push_back(row); }).add_all(*reader);
  return all_rows;
}

TEST(RecordingRows, AnyJumpFindsTheSampleThatAReadingOfAllFinds) {
  OpenedRecording opened;
  const std::vector<CycleRow> all_rows = read_all(opened.file);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> times(-0.5, 4.5);
  for (int i = 0; i < 60; ++i) {
    const double t_s = times(random);
    const CycleRow* row = opened.rows->at(t_s);
    ASSERT_NE(row, nullptr);
    EXPECT_EQ(row->sample, brute_force_sample(all_rows, t_s)) << t_s;
    EXPECT_EQ(std::isfinite(row->p_WP.x()), row->sample % 2 == 0) << t_s;
  }
}

TEST(RecordingRows, ReadingOnFindsEverySample) {
  OpenedRecording opened;
  for (std::uint64_t sample = 1; sample <= 4000; sample += 16) {
    const CycleRow* row = opened.rows->at(1e-3 * (static_cast<double>(sample) + 0.5));
    ASSERT_NE(row, nullptr);
    ASSERT_EQ(row->sample, sample);
  }
}

TEST(RecordingRows, StepsGoFromSampleToSampleBothWays) {
  OpenedRecording opened;
  double t_s = opened.rows->at(2.5)->sample_t_s;
  for (std::uint64_t sample = 2501; sample < 2510; ++sample) {
    const auto next = opened.rows->next_s(t_s);
    ASSERT_TRUE(next);
    t_s = *next;
    EXPECT_EQ(opened.rows->at(t_s)->sample, sample);
  }
  for (std::uint64_t sample = 2508; sample > 1000; --sample) {
    const auto previous = opened.rows->previous_s(t_s);
    ASSERT_TRUE(previous) << sample;
    t_s = *previous;
    ASSERT_EQ(opened.rows->at(t_s)->sample, sample);
  }
  EXPECT_FALSE(opened.rows->next_s(opened.index.end_s()));
  EXPECT_FALSE(opened.rows->previous_s(opened.index.begin_s()));
}

TEST(RecordingRows, TheNewestSampleWithAReplyIsFound) {
  OpenedRecording opened;
  const CycleRow* replied = opened.rows->replied_at(2.0015, 0.02);
  ASSERT_NE(replied, nullptr);
  EXPECT_EQ(replied->sample, 2000U);
  EXPECT_EQ(replied->view_revision, 4U);
  EXPECT_EQ(replied->scene_time_ns, 2'000'000'000);
  EXPECT_EQ(opened.rows->replied_at(2.0015, 0.0005), nullptr) << "older than requested";
  const std::vector<double> trips = opened.rows->round_trips(3.0);
  EXPECT_NEAR(static_cast<double>(trips.size()), 500.0, 2.0);
  EXPECT_NEAR(trips.front(), 3e-4, 1e-9);
}

TEST(RecordingRows, RoundTripsAreSortedAndCoverTheLastSecond) {
  MadeRecording recording;
  recording.slower_ns = 200'000;
  OpenedRecording opened(std::move(recording));
  const std::vector<double> trips = opened.rows->round_trips(3.0005);
  ASSERT_EQ(trips.size(), 500U) << "one sample in two has a reply";
  for (std::size_t n = 0; n < trips.size(); ++n) EXPECT_NEAR(trips[n], n < 250 ? 3e-4 : 5e-4, 1e-9) << n;
  EXPECT_TRUE(opened.rows->round_trips(0.0015).empty());
  EXPECT_EQ(opened.rows->round_trips(0.0025).size(), 1U);
}

// Goes back after rows were dropped. 1.3005 s itself is still in memory then, but not all of the second before it that round_trips() needs.
TEST(RecordingRows, GoingBackReadsDroppedRowsAgain) {
  OpenedRecording opened;
  for (const double t_s : {0.1005, 1.5005, 2.9005, 3.9005}) ASSERT_EQ(opened.rows->at(t_s)->sample, static_cast<std::uint64_t>(1e3 * t_s));
  for (const double t_s : {1.2005, 0.3005, 3.2005, 2.2005, 1.3005, 0.1005}) {
    EXPECT_EQ(opened.rows->at(t_s)->sample, static_cast<std::uint64_t>(1e3 * t_s)) << t_s;
    EXPECT_EQ(opened.rows->round_trips(t_s).size(), static_cast<std::size_t>(500.0 * std::min(t_s, 1.0))) << t_s;
  }
}

TEST(RecordingRows, BeforeTheFirstSampleTheFirstIsShown) {
  OpenedRecording opened;
  for (const double t_s : {-7.0, 0.0, 0.0005}) {
    ASSERT_NE(opened.rows->at(t_s), nullptr);
    EXPECT_EQ(opened.rows->at(t_s)->sample, 1U) << t_s;
    EXPECT_EQ(opened.rows->replied_at(t_s, 1.0), nullptr) << t_s;
    EXPECT_DOUBLE_EQ(opened.rows->next_s(t_s).value_or(-1.0), 0.001) << t_s;
    EXPECT_FALSE(opened.rows->previous_s(t_s)) << t_s;
  }
  EXPECT_EQ(opened.rows->at(99.0)->sample, 4000U) << "after the last, the last";
}

TEST(RecordingRows, AReplyAsOldAsRequestedIsFound) {
  OpenedRecording opened;
  const double sample_t_s = opened.rows->at(2.0005)->sample_t_s;
  ASSERT_NE(opened.rows->replied_at(sample_t_s + 0.0009, 0.001), nullptr);
  EXPECT_EQ(opened.rows->replied_at(sample_t_s, 0.0)->sample, 2000U);
}

// As after a device was unplugged: datagrams are recorded, but no samples.
TEST(RecordingRows, AfterTheLastSampleItIsShownAlsoWhereMoreWasRecorded) {
  MadeRecording recording;
  recording.also = [&](std::uint64_t sample) {
    for (std::uint64_t later = 5000; sample == 4000 && later <= 9000; later += 100) {
      recording.receive(MadeRecording::kVision, SceneFacts{.given_hash = 99}, later);
    }
  };
  OpenedRecording opened(std::move(recording));
  for (const double t_s : {8.5, 99.0, 4.5}) {
    const CycleRow* row = opened.rows->at(t_s);
    ASSERT_NE(row, nullptr) << t_s;
    EXPECT_EQ(row->sample, 4000U) << t_s;
  }
}

TEST(RecordingRows, InAGapTheSampleBeforeItIsShown) {
  MadeRecording recording;
  recording.lost_from = 200;
  recording.lost_to = 3800;
  OpenedRecording opened(std::move(recording));
  EXPECT_EQ(opened.rows->at(3.0)->sample, 199U);
  EXPECT_EQ(opened.rows->at(3.9005)->sample, 3900U);
  EXPECT_EQ(opened.rows->at(2.0)->sample, 199U);
  const auto next = opened.rows->next_s(2.0);
  ASSERT_TRUE(next);
  EXPECT_DOUBLE_EQ(*next, 3.8);
  const auto previous = opened.rows->previous_s(*next);
  ASSERT_TRUE(previous);
  EXPECT_DOUBLE_EQ(*previous, 0.199);
}

}  // namespace
}  // namespace hapton
