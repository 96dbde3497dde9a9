#include "vision_node/recorded_state.h"

#include <gtest/gtest.h>

#include "tests/session/opened_recording.h"

namespace hapton {
namespace {

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

TEST(RecordedState, PlotsEndAtTheMomentShown) {
  OpenedRecording recording;
  const std::vector<PlotShown> plots = make_recorded_plots(recording.index, 1.0);
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

}  // namespace
}  // namespace hapton
