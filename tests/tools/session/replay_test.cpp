#include "tools/session/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchStep make_touch() { return TouchStep(*make_method({.name = "sweep"}, {.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}})); }

std::vector<TrajectoryRow> rows_at_heights(const std::vector<double>& heights) {
  std::vector<TrajectoryRow> rows;
  for (const double height : heights) {
    rows.push_back({.t_s = 1e-3 * static_cast<double>(rows.size()), .p_WD = Vec3(0.01, 0.02, height)});
  }
  return rows;
}

// Each reading takes 7 ns.
class SteppingClock final : public Clock {
 public:
  std::int64_t now_ns() const noexcept override { return now_ += 7; }
  void sleep_until_ns(std::int64_t deadline_ns) noexcept override { now_ = deadline_ns; }

 private:
  mutable std::int64_t now_ = 0;
};

TEST(Replay, RowsAreTheOutputOfTheStep) {
  TouchStep touch = make_touch();
  const auto trajectory = rows_at_heights({0.001, -0.001, -0.003, 0.002});
  const Replay replay = run_replay(touch, trajectory, {}, SteadyClock());
  ASSERT_EQ(replay.rows.size(), 4U);
  EXPECT_FALSE(replay.rows[0].contact);
  EXPECT_TRUE(replay.rows[1].contact);
  EXPECT_NEAR(replay.rows[2].force_n[2], 3.0, 1e-9);
  EXPECT_NEAR((replay.rows[2].p_WP - Vec3(0.01, 0.02, 0.0)).norm(), 0.0, 1e-15);
  EXPECT_FALSE(replay.rows[3].contact);
  EXPECT_EQ(replay.rows[3].p_WP, trajectory[3].p_WD);
  EXPECT_EQ(replay.rows[3].t_s, 0.003);
}

TEST(Replay, ContactIsForgottenAtEachReset) {
  TouchStep touch = make_touch();
  const auto trajectory = rows_at_heights({0.001, -0.001, -0.001, -0.001, -0.001});
  const Replay replay = run_replay(touch, trajectory, {.reset_every = 3}, SteadyClock());
  EXPECT_TRUE(replay.rows[2].contact);
  EXPECT_FALSE(replay.rows[3].contact);
  EXPECT_FALSE(replay.rows[4].contact);
}

TEST(Replay, RepetitionsStartAgainAndGiveTheSameForces) {
  TouchStep touch = make_touch();
  const Replay replay = run_replay(touch, rows_at_heights({0.001, -0.001, -0.002}), {.repeat = 5}, SteadyClock());
  EXPECT_EQ(replay.rows_that_differ, 0U);
  EXPECT_TRUE(replay.rows[2].contact);
}

TEST(Replay, TheClocksOwnCostIsSubtracted) {
  TouchStep touch = make_touch();
  const Replay replay = run_replay(touch, rows_at_heights({0.001, -0.001}), {.repeat = 2}, SteppingClock());
  EXPECT_EQ(replay.clock_cost_ns, 7);
  EXPECT_EQ(replay.rows[0].step_ns, 0);
}

// Readings come in pairs, before and after a step. The second one is later by the next value of step_times_ns, while there is one.
class StepTimesClock final : public Clock {
 public:
  std::int64_t now_ns() const noexcept override {
    const bool ends_step = ++readings_ % 2 == 0;
    if (ends_step && next_step_ < step_times_ns.size()) now_ += step_times_ns[next_step_++];
    return now_;
  }
  void sleep_until_ns(std::int64_t deadline_ns) noexcept override { now_ = deadline_ns; }
  std::size_t readings() const { return readings_; }

  std::vector<std::int64_t> step_times_ns;

 private:
  mutable std::int64_t now_ = 0;
  mutable std::size_t readings_ = 0;
  mutable std::size_t next_step_ = 0;
};

TEST(Replay, TheTimeOfAStepIsTheLeastOfItsRepetitions) {
  TouchStep touch = make_touch();
  StepTimesClock clock;
  run_replay(touch, {}, {}, clock);
  // Each run reads the clock this often before its first step: these readings take no time.
  clock.step_times_ns.assign(clock.readings() / 2, 0);
  for (const std::int64_t ns : {50, 20, 30, 40, 90, 10}) clock.step_times_ns.push_back(ns);
  const Replay replay = run_replay(touch, rows_at_heights({0.001, -0.001}), {.repeat = 3}, clock);
  EXPECT_EQ(replay.rows[0].step_ns, 30);
  EXPECT_EQ(replay.rows[1].step_ns, 10);
}

// Clay stays carved, so each repetition finds another body; the forces in the rows are those of the first repetition.
TEST(Replay, RowsThatDifferBetweenRepetitionsAreCountedAndReported) {
  const TouchScene scene{.objects = {{.mesh = std::make_shared<const TriangleMesh>(make_icosphere(0.03, 3)),
                                      .material = {.stiffness_n_per_m = 500.0},
                                      .sculpt = SculptSettings{.voxel_m = 0.001, .tool_radius_m = 0.004, .button = 1}}}};
  std::vector<TrajectoryRow> trajectory;
  for (std::uint32_t n = 0; n < 100; ++n) {
    trajectory.push_back({.t_s = 1e-3 * n, .p_WD = Vec3(0.0, 0.0, 0.035 - 1e-4 * n), .buttons = n < 70 ? 0U : 1U});
  }
  const auto replay_of = [&](std::size_t repeat) {
    TouchStep touch(*make_method({.name = "proxy"}, scene), scene);
    return run_replay(touch, trajectory, {.repeat = repeat}, SteadyClock());
  };
  const Replay once = replay_of(1);
  const Replay twice = replay_of(2);
  EXPECT_EQ(once.rows_that_differ, 0U);
  EXPECT_GT(twice.rows_that_differ, 0U);
  EXPECT_LE(twice.rows_that_differ, trajectory.size());
  for (std::size_t n = 0; n < trajectory.size(); ++n) {
    EXPECT_EQ(twice.rows[n].force_n, once.rows[n].force_n) << n;
    EXPECT_EQ(twice.rows[n].contact, once.rows[n].contact) << n;
  }
  EXPECT_THAT(describe_replay(twice, {.repeat = 2}),
              ::testing::HasSubstr("note: " + std::to_string(twice.rows_that_differ) + " steps differed between repetitions\n"));
  EXPECT_THAT(describe_replay(once, {}), ::testing::Not(::testing::HasSubstr("note:")));
}

TEST(Replay, TheSummarySaysWhereAToolHadNoRoom) {
  Replay replay{.rows = {{.is_blocked = true}, {.is_squeezed = true}, {.is_squeezed = true}, {}}, .has_tool = true};
  replay.rows[3].torque_nm = Vec3(0.0, 0.03, 0.04);
  const std::string text = describe_replay(replay, {});
  EXPECT_THAT(text, ::testing::HasSubstr("torque max 0.05 Nm\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("note: 1 steps without force: the tool overlapped the scene where it started\n"));
  EXPECT_THAT(text, ::testing::HasSubstr("note: in 2 steps the tool had no room"));
}

// Recorded times begin anywhere; waves and keyframes begin with the first row.
TEST(Replay, ATrajectoryThatBeginsLaterGivesTheSameForces) {
  const auto motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(), std::vector<Keyframe>{{0.0, Vec3::Zero(), Quat::Identity()}, {0.2, Vec3(0.0, 0.0, 0.005), Quat::Identity()}}, false);
  TouchScene scene{.objects = {{made::shared(made::sheet(0.1, 0.0, 6)), {}}}};
  scene.objects[0].motion = motion;
  // half_height_m: of the held box; zero for a point.
  const auto trajectory_from = [](double begin_s, double half_height_m) {
    std::vector<TrajectoryRow> trajectory;
    for (int n = 0; n < 200; ++n) trajectory.push_back({.t_s = begin_s + 1e-3 * n, .p_WD = Vec3(0.01, 0.02, half_height_m + 0.00101)});
    return trajectory;
  };
  const auto replay_point_from = [&](double begin_s) {
    TouchStep touch(*make_method({.name = "proxy"}, scene), scene);
    return run_replay(touch, trajectory_from(begin_s, 0.0), {}, SteadyClock());
  };
  const auto replay_tool_from = [&](double begin_s) {
    auto tool = ToolStep::make(make_box({0.02, 0.02, 0.02}), {scene.objects[0].mesh}, {}, {}, nullptr, {1});
    EXPECT_TRUE(tool);
    const std::vector<ToolPart> parts = {{.motion = motion}};
    return run_replay(**tool, trajectory_from(begin_s, 0.01), {}, SteadyClock(), parts);
  };
  for (const auto& [first, later] :
       {std::pair{replay_point_from(0.0), replay_point_from(5.0)}, std::pair{replay_tool_from(0.0), replay_tool_from(5.0)}}) {
    EXPECT_GT(first.rows[199].force_n.z(), 1.0) << "the surface has risen above the hand";
    EXPECT_LT(first.rows[10].force_n.z(), 0.1) << "it is still below";
    for (std::size_t n = 0; n < first.rows.size(); ++n) {
      EXPECT_NEAR((later.rows[n].force_n - first.rows[n].force_n).norm(), 0.0, 0.05) << n;
    }
  }
}

TEST(Replay, TheSummarySaysTheWorstStepAndTheTail) {
  Replay replay;
  for (int i = 1; i <= 2000; ++i) {
    replay.rows.push_back({.force_n = Vec3(0, 0, i % 2), .contact = i % 2 == 1, .step_ns = i});
  }
  replay.rows.back().step_ns = 123456;
  const std::string text = describe_replay(replay, {.repeat = 3});
  EXPECT_THAT(text, ::testing::HasSubstr("2000 steps, 1000 in contact"));
  EXPECT_THAT(text, ::testing::HasSubstr("all p50 1000 / p99 1980 / p99.9 1998 / worst 123456 ns"));
  EXPECT_THAT(text, ::testing::HasSubstr("contact p50 999 / p99 1979 / p99.9 1997 / worst 1999 ns"));
}

TEST(Replay, CsvKeepsEveryBit) {
  const auto path = std::filesystem::temp_directory_path() / ("hapton_replay_" + std::to_string(::getpid()) + ".csv");
  const ReplayRow row = {.t_s = 0.1,
                         .p_WD = Vec3(1.0 / 3, -1e-17, 2e300),
                         .p_WP = Vec3(0.1, 0.2, 0.3),
                         .force_n = Vec3(-1.0 / 7, 0, 5e-324),
                         .contact = true,
                         .step_ns = 42};
  ASSERT_TRUE(write_replay_csv(path, Replay{.rows = {row}}));
  std::ifstream file(path);
  std::string header;
  std::string line;
  std::getline(file, header);
  std::getline(file, line);
  std::filesystem::remove(path);
  EXPECT_EQ(header, "t_s,x_m,y_m,z_m,proxy_x_m,proxy_y_m,proxy_z_m,fx_n,fy_n,fz_n,contact,step_ns");
  std::vector<std::string> fields;
  std::stringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    fields.push_back(field);
  }
  ASSERT_EQ(fields.size(), 12U);
  const std::vector<double> expected = {0.1, 1.0 / 3, -1e-17, 2e300, 0.1, 0.2, 0.3, -1.0 / 7, 0, 5e-324, 1, 42};
  for (std::size_t i = 0; i < fields.size(); ++i) {
    EXPECT_EQ(std::strtod(fields[i].c_str(), nullptr), expected[i]) << i;
  }
}

// A tool that is computed by voxels fills the same columns.
TEST(Replay, AToolByVoxelsIsFeltToo) {
  auto tool = VoxelTool::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(make_plane_grid(0.2, 4))}, {}, 0.001);
  ASSERT_TRUE(tool);
  std::vector<TrajectoryRow> trajectory;
  for (int n = 0; n < 400; ++n) trajectory.push_back({1e-3 * n, {0.0, 0.0, 0.02 - 3e-5 * n}, Quat::Identity()});
  const Replay replay = run_replay(**tool, trajectory, {}, SteadyClock());
  ASSERT_TRUE(replay.has_tool);
  EXPECT_TRUE(replay.rows.back().contact);
  EXPECT_NEAR(replay.rows.back().force_n.z(), 1.97, 1.0) << "one voxel more or less changes the force by a newton";
}

TEST(Replay, ATrajectoryGivesAToolTheTimeThatDampingNeeds) {
  auto tool = ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(make_plane_grid(0.2, 4))}, {});
  ASSERT_TRUE(tool);
  ASSERT_TRUE((*tool)->damp({{.normal_ns_per_m = 4.0}}));
  std::vector<TrajectoryRow> trajectory;
  for (int n = 0; n < 400; ++n) trajectory.push_back({2e-3 * n, {0.0, 0.0, 0.02 - 3e-5 * n}, Quat::Identity()});
  const Replay replay = run_replay(**tool, trajectory, {}, SteadyClock());
  EXPECT_NEAR(replay.rows.back().force_n.z(), 1000.0 * (0.01 - trajectory.back().p_WD.z()) + 4.0 * 0.015, 2e-3);
}

// The effects act at the tool's grip point, with the buttons of the trajectory; each reset starts them anew.
TEST(Replay, EffectsInFreeSpaceAreAddedToATool) {
  std::vector<TrajectoryRow> trajectory;
  for (int n = 0; n < 100; ++n) trajectory.push_back({1e-3 * n, {0.0, 0.0, 0.05 + 1e-4 * n}, Quat::Identity()});
  for (int n = 30; n < 100; ++n) trajectory[static_cast<std::size_t>(n)].buttons = 1;
  auto tool = ToolStep::make(make_box({0.02, 0.02, 0.02}), {std::make_shared<TriangleMesh>(make_plane_grid(0.2, 4))}, {});
  ASSERT_TRUE(tool);
  const ReplaySettings settings{.reset_every = 60};
  Replay replay = run_replay(**tool, trajectory, settings, SteadyClock());
  add_space_effects({}, trajectory, settings, replay);
  EXPECT_FALSE(replay.rows[50].contact);
  add_space_effects({SpringEffect{.stiffness_n_per_m = 20.0}, {ConstantEffect{.force_n = {0.4, 0.0, 0.0}}, EffectSwitch{.button = 1}}},
                    trajectory, settings, replay);
  for (std::size_t n = 0; n < 100; ++n) {
    EXPECT_NEAR(replay.rows[n].force_n.z(), -20.0 * trajectory[n].p_WD.z(), 1e-12) << n;
    EXPECT_TRUE(replay.rows[n].contact);
  }
  EXPECT_EQ(replay.rows[29].force_n.x(), 0.0);
  EXPECT_NEAR(replay.rows[59].force_n.x(), 0.4, 1e-12) << "20 ms after the press";
  EXPECT_EQ(replay.rows[99].force_n.x(), 0.0) << "the button was down at the reset";
}

TEST(Replay, AToolAddsItsOrientationAndTorque) {
  const TriangleMesh box = make_box({0.02, 0.02, 0.02});
  auto tool = ToolStep::make(box, {std::make_shared<TriangleMesh>(make_plane_grid(0.2, 4))}, {});
  ASSERT_TRUE(tool);
  std::vector<TrajectoryRow> trajectory;
  for (int n = 0; n < 200; ++n) {
    trajectory.push_back({1e-3 * n, {0.0, 0.0, 0.02 - 1e-4 * n}, turn_by({0.0, 0.2, 0.0})});
  }
  const Replay replay = run_replay(**tool, trajectory, {.repeat = 2}, SteadyClock());
  EXPECT_EQ(replay.rows_that_differ, 0U);
  ASSERT_TRUE(replay.has_tool);
  const ReplayRow& last = replay.rows.back();
  EXPECT_TRUE(last.contact);
  EXPECT_GT(last.force_n.z(), 1.0);
  EXPECT_GT(std::abs(last.torque_nm.y()), 1e-3);
  EXPECT_LT(turn_between(Quat::Identity(), last.q_WP).norm(), 0.2) << "the plane turns it back";
  const auto path = std::filesystem::temp_directory_path() / "hapton_tool_replay_test.csv";
  ASSERT_TRUE(write_replay_csv(path, replay));
  std::ifstream file(path);
  std::string header;
  std::string line;
  std::getline(file, header);
  std::getline(file, line);
  std::filesystem::remove(path);
  EXPECT_EQ(header,
            "t_s,x_m,y_m,z_m,proxy_x_m,proxy_y_m,proxy_z_m,fx_n,fy_n,fz_n,contact,step_ns,proxy_qw,proxy_qx,proxy_qy,proxy_qz,tx_nm,ty_nm,"
            "tz_nm");
  EXPECT_EQ(std::count(line.begin(), line.end(), ','), 18);
}

TEST(Replay, AFolderThatIsNotThereIsAnError) {
  const auto written = write_replay_csv("/nonexistent/folder/r.csv", {});
  ASSERT_FALSE(written);
  EXPECT_THAT(written.error().what, ::testing::HasSubstr("/nonexistent/folder/r.csv"));
}

}  // namespace
}  // namespace hapton
