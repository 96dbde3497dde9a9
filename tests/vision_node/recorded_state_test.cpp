#include "vision_node/recorded_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/recording/opened_recording.h"

namespace hapton {
namespace {

// The expected values are those of MadeRecording.
TEST(RecordedState, IsWhatTheHubShowedThen) {
  OpenedRecording recording;
  const auto touched = find_recorded_state(recording.index, *recording.rows, 2.4005);
  ASSERT_TRUE(touched);
  EXPECT_TRUE(touched->has_reply);
  EXPECT_EQ(touched->state.sample, 2400U);
  EXPECT_NEAR(touched->state.p_WD.x(), 0.24, 1e-12);
  EXPECT_NEAR(touched->state.visual_offset_m.z(), 1e-3, 1e-12);
  EXPECT_TRUE(touched->state.contact);
  EXPECT_EQ(touched->state.object, 1);
  EXPECT_NEAR(touched->state.force_n.z(), 0.5, 1e-12) << "what the motors got, not what was requested";
  EXPECT_NEAR(touched->X_WS.translation().x(), 0.25, 1e-6);
  EXPECT_NEAR(touched->state.servo_rate_hz, 1000.0, 1.0);
  EXPECT_NEAR(touched->state.round_trip_p50_us, 300.0, 1.0);
  EXPECT_EQ(touched->state.scene_time_ns, 2'400'000'000);
  EXPECT_EQ(touched->state.status, ProbeStatus::ok);
  const auto free = find_recorded_state(recording.index, *recording.rows, 1.2005);
  ASSERT_TRUE(free);
  EXPECT_FALSE(free->state.contact);
  EXPECT_EQ(free->X_WS.translation().x(), 0.0);
  EXPECT_EQ(find_recorded_state(recording.index, *recording.rows, 3.0)->state.status, ProbeStatus::fault_latched);
}

TEST(RecordedState, RateIsThatOfTheSecondBefore) {
  OpenedRecording recording;
  for (const double t_s : {0.001, 0.3, 1.0, 3.9, 4.0}) EXPECT_NEAR(find_recorded_rate_hz(recording.index, t_s), 1000.0, 1.0) << t_s;
}

// In the rate, missing samples count as time in which no sample came.
TEST(RecordedState, TheRateFallsWhereSamplesAreMissing) {
  MadeRecording made;
  made.lost_from = 1000;
  made.lost_to = 1500;
  OpenedRecording recording(std::move(made));
  EXPECT_NEAR(find_recorded_rate_hz(recording.index, 1.75), 500.0, 0.5) << "half of the second from 0.74 s to 1.74 s";
  EXPECT_NEAR(find_recorded_rate_hz(recording.index, 0.9), 1000.0, 0.5);
  EXPECT_NEAR(find_recorded_rate_hz(recording.index, 3.0), 1000.0, 0.5);
}

TEST(RecordedState, QuantilesAreThoseOfTheSecondBefore) {
  MadeRecording made;
  made.slower_ns = 200'000;
  OpenedRecording recording(std::move(made));
  const auto state = find_recorded_state(recording.index, *recording.rows, 3.0005);
  ASSERT_TRUE(state);
  EXPECT_NEAR(state->state.round_trip_p50_us, 300.0, 0.1) << "half of the replies are slower";
  EXPECT_NEAR(state->state.round_trip_p99_us, 500.0, 0.1);
}

// The haptics node announces its scene, but never replies to a sample.
TEST(RecordedState, WithoutAReplyTheNewestSampleIsShown) {
  MadeRecording made;
  made.has_replies = false;
  OpenedRecording recording(std::move(made));
  const auto early = find_recorded_state(recording.index, *recording.rows, 0.0505);
  ASSERT_TRUE(early);
  EXPECT_FALSE(early->has_reply);
  EXPECT_EQ(early->state.sample, 50U);
  EXPECT_EQ(early->state.sample_time_ns, 50'000'000);
  EXPECT_EQ(early->state.status, ProbeStatus::no_haptics);
  EXPECT_EQ(early->state.buttons, 5U);
  EXPECT_EQ(early->state.visual_offset_m, Vec3(0.0, 0.0, 0.0));
  EXPECT_EQ(early->state.visual_turn, Vec3(0.0, 0.0, 0.0));
  EXPECT_EQ(early->state.round_trip_p50_us, 0.0F);
  EXPECT_FALSE(early->state.contact);
  EXPECT_NEAR(early->state.force_n.z(), 0.5, 1e-12);
  const auto later = find_recorded_state(recording.index, *recording.rows, 3.0005);
  ASSERT_TRUE(later);
  EXPECT_EQ(later->state.status, ProbeStatus::fault_latched) << "the status of the hub takes precedence";
  EXPECT_NEAR(later->X_WS.translation().x(), 0.25, 1e-6) << "the newest view";
}

// From 2 s to 2.1 s there is no reply: the last one before counts for 20 ms.
TEST(RecordedState, AReplyCountsForTwentyMilliseconds) {
  MadeRecording made;
  made.lost_from = 2001;
  made.lost_to = 2100;
  OpenedRecording recording(std::move(made));
  const auto shown = find_recorded_state(recording.index, *recording.rows, 2.0195);
  ASSERT_TRUE(shown);
  EXPECT_TRUE(shown->has_reply);
  const auto old = find_recorded_state(recording.index, *recording.rows, 2.0205);
  ASSERT_TRUE(old);
  EXPECT_FALSE(old->has_reply);
  EXPECT_EQ(old->state.status, ProbeStatus::ok) << "from the newest state of the hub";
}

TEST(RecordedState, ATurnedToolIsShownTurned) {
  const Vec3 turn(0.1, -0.2, 0.3);
  MadeRecording made;
  made.has_replies = false;
  made.also = [&](std::uint64_t sample) {
    ForceCommand force = force_of(sample);
    force.visual_turn = turn;
    force.torque_nm = Vec3(0.0, 0.01, 0.0);
    made.receive(MadeRecording::kHaptics, force, sample);
  };
  ScratchFolder scratch;
  const auto file = made.write(scratch);
  auto reader = SessionReader::open(file);
  const auto index = RecordingIndex::read(*reader);
  ASSERT_TRUE(index);
  auto rows = RecordingRows::open(file, *index);
  ASSERT_TRUE(rows);
  const auto state = find_recorded_state(*index, *rows, 1.0);
  ASSERT_TRUE(state);
  EXPECT_LT((state->state.visual_turn - turn).norm(), 1e-6);
  EXPECT_EQ(state->state.torque_nm, Vec3(0.0, 0.0, 0.0)) << "what the motors got";
}

TEST(RecordedState, TheTorqueIsThatOfTheMotors) {
  MadeRecording made;
  made.written_nm = Vec3(0.0, 0.02, -0.01);
  OpenedRecording recording(std::move(made));
  for (const double t_s : {2.4005, 2.4015}) {  // the sample of the first time has a reply, that of the second has none
    const auto state = find_recorded_state(recording.index, *recording.rows, t_s);
    ASSERT_TRUE(state);
    EXPECT_EQ(state->state.torque_nm, Vec3(0.0, 0.02, -0.01)) << t_s;
  }
}

TEST(RecordedState, PlotsHaveTheLastFiveSecondsAndTheLimit) {
  ScratchFolder scratch;
  MadeRecording made;
  made.samples = 7000;
  made.also = [&](std::uint64_t sample) {
    if (sample == 5000) made.notice({.force_limit_n = 8.0F}, sample);
  };
  const auto file = made.write(scratch);
  auto reader = SessionReader::open(file);
  const auto index = RecordingIndex::read(*reader);
  ASSERT_TRUE(index);
  const std::vector<PlotContent> plots = make_recorded_plots(*index, 6.9);
  ASSERT_EQ(plots.size(), 2U);
  for (const PlotContent& plot : plots) {
    ASSERT_FALSE(plot.points.empty());
    EXPECT_LE(plot.points.front().age_s, RecentCurve::kSeconds);
    EXPECT_GT(plot.points.front().age_s, RecentCurve::kSeconds - 0.021);
    EXPECT_TRUE(std::ranges::is_sorted(plot.points, {}, [](const CurvePoint& point) { return -point.age_s; }));
  }
  EXPECT_EQ(plots[0].limit, 8.0);
  EXPECT_EQ(plots[0].top, 10.0);
  EXPECT_EQ(plots[1].limit, 0.0);
  EXPECT_EQ(plots[1].top, 1.0);
  EXPECT_EQ(make_recorded_plots(*index, 4.9)[0].limit, 0.0) << "not known yet";
}

TEST(RecordedState, AMarkIsShownForTwoSeconds) {
  MadeRecording made;
  made.samples = 6000;
  OpenedRecording recording(std::move(made));
  EXPECT_EQ(describe_mark(recording.index, 5.49), "marker: trial 8");
  EXPECT_EQ(describe_mark(recording.index, 5.51), "");
  EXPECT_EQ(describe_mark(recording.index, 2.5 - 5e-7), "FAULT: clamped") << "a moment that rounding made earlier";
  EXPECT_EQ(describe_mark(recording.index, 2.499), "marker: trial 7");
}

TEST(RecordedState, PlotsEndAtTheMomentShown) {
  OpenedRecording recording;
  const std::vector<PlotContent> plots = make_recorded_plots(recording.index, 1.0);
  ASSERT_EQ(plots.size(), 2U);
  ASSERT_FALSE(plots[0].points.empty());
  EXPECT_NEAR(plots[0].points.front().age_s, 1.0, 0.021);
  EXPECT_NEAR(plots[0].points.back().age_s, 0.0, 0.021);
  EXPECT_DOUBLE_EQ(plots[0].points.back().value, 0.5);
  EXPECT_NEAR(plots[1].points.back().value, 0.3, 1e-6) << "ms";
}

TEST(RecordedState, IsDescribedInOneLineEach) {
  OpenedRecording recording;
  SessionPlayer player(recording.index.begin_s(), recording.index.end_s());
  player.seek(2.5);
  player.pause();
  EXPECT_EQ(describe_recording("a.hapton", player, 2500), "recording a.hapton   0:02.500 of 0:04.000   sample 2500   1x, paused");
  EXPECT_EQ(describe_mark(recording.index, 2.5), "FAULT: clamped");
  EXPECT_EQ(describe_mark(recording.index, 1.4), "marker: trial 7");
  EXPECT_EQ(describe_mark(recording.index, 0.9), "");
}

TEST(RecordedState, HasTheEnergyAndTheLargestForceThatTheHubReported) {
  ScratchFolder scratch;
  MadeRecording made;
  made.also = [&](std::uint64_t sample) {
    if (sample == 1500) made.notice({.energy_percent = 40, .force_limit_n = 8.5F}, sample);
  };
  const auto file = made.write(scratch);
  auto reader = SessionReader::open(file);
  const auto index = RecordingIndex::read(*reader);
  ASSERT_TRUE(index);
  auto rows = RecordingRows::open(file, *index);
  ASSERT_TRUE(rows);
  const auto before = find_recorded_state(*index, *rows, 1.4);
  ASSERT_TRUE(before);
  EXPECT_EQ(before->state.energy_percent, 0U);
  EXPECT_EQ(before->state.force_limit_n, 0.0F);
  const auto after = find_recorded_state(*index, *rows, 2.0);
  ASSERT_TRUE(after);
  EXPECT_EQ(after->state.energy_percent, 40U);
  EXPECT_EQ(after->state.force_limit_n, 8.5F);
}

}  // namespace
}  // namespace hapton
