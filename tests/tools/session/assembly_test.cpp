// A peg is put into its hole by the simulated hand: device, haptics step, slow and fast task of the tool, and governor, on simulated time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/math/rotation_vector.h"
#include "core/tool/penetration_check.h"
#include "devices/simulated_phantom.h"
#include "haptic_step/haptics_step.h"
#include "runtime/trajectory_csv.h"
#include "safety/safety_governor.h"
#include "scene/scene_file.h"

namespace hapton {
namespace {

constexpr std::int64_t kCycleNs = 1'000'000;

struct AssemblyRun {
  std::vector<Vec3> grip_points;  // the grip point of the drawn tool, one position for each cycle
  double max_force_n = 0.0;
  double max_torque_nm = 0.0;
  int penetrations = 0;
  int blocked_cycles = 0;
};

// The hand takes the tool of a scene along a path. The pose of the tool is computed once in cycles_per_pose cycles.
AssemblyRun follow_path(const std::string& scene_name, const std::vector<TrajectoryRow>& path, bool has_torque, int cycles_per_pose) {
  AssemblyRun run;
  const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/" + scene_name + ".toml");
  EXPECT_TRUE(scene && scene->tool) << scene_name;
  if (!scene || !scene->tool) return run;
  std::vector<std::shared_ptr<const TriangleMesh>> meshes;
  for (const SceneObject& object : scene->objects) meshes.push_back(object.mesh);
  HeldTool tool(std::move(*ToolStep::make(*scene->tool->mesh, meshes, {.stiffness_n_per_m = 800.0})));
  HapticsStep step(std::make_unique<TouchStep>(std::move(*make_method({}, scene->touch_scene())), scene->touch_scene()), 1e-5);
  step.hold(&tool);
  SimulatedPhantom device({.path = path, .has_torque = has_torque});
  SafetyGovernor governor(device.limits());
  PenetrationCheck check(tool.tool().tool(), tool.tool().scene());
  const auto cycles = static_cast<std::uint64_t>(1000.0 * (path.back().t_s + 1.5));
  for (std::uint64_t sample = 1; sample <= cycles; ++sample) {
    const std::int64_t now_ns = static_cast<std::int64_t>(sample) * kCycleNs;
    const DeviceSample read = device.read(now_ns);
    governor.observe(read, device.status());
    step.offer({.sample = sample, .sample_time_ns = now_ns, .p_WD = read.p_WD, .q_WT = read.q_WT});
    const ForceCommand command = step.reply();
    if (sample % static_cast<std::uint64_t>(cycles_per_pose) == 0) tool.follow();
    const Wrench written = governor.step(WrenchCommand{{command.force_n, command.torque_nm}, now_ns}, now_ns);
    device.write(written, now_ns);
    run.max_force_n = std::max(run.max_force_n, written.force_n.norm());
    run.max_torque_nm = std::max(run.max_torque_nm, written.torque_nm.norm());
    run.blocked_cycles += step.is_tool_blocked() ? 1 : 0;
    if (sample % 50 == 0) run.penetrations += check.penetrates(tool.tool().proxy().placement()) ? 1 : 0;
    run.grip_points.push_back(read.p_WD + command.visual_offset_m);
  }
  EXPECT_EQ(governor.fault(), SafetyFault::none);
  return run;
}

// The path begins 0.6 mm beside the axis of the hole, tilted by two degrees, and then leads into the hole.
AssemblyRun put_peg_into(double hole_x_m, bool has_torque, int cycles_per_pose) {
  const Quat first_tilt = turn_by({0.035, 0.0, 0.0});
  const Quat second_tilt = turn_by({0.0, -0.026, 0.0});
  return follow_path("pegs",
                     {{0.0, {hole_x_m + 0.0006, 0.0003, 0.05}, first_tilt},
                      {1.0, {hole_x_m + 0.0006, 0.0003, 0.026}, first_tilt},
                      {2.0, {hole_x_m + 0.0003, -0.0004, -0.008}, second_tilt},
                      {3.0, {hole_x_m + 0.0003, -0.0004, -0.008}, second_tilt}},
                     has_torque, cycles_per_pose);
}

TEST(Assembly, ThePegGoesIntoEachOfItsHoles) {
  for (const double hole_x_m : {-0.026, 0.0, 0.026}) {
    const AssemblyRun run = put_peg_into(hole_x_m, true, 1);
    EXPECT_LT(run.grip_points.back().z(), -0.006) << "it went in";
    EXPECT_EQ(run.penetrations, 0);
    EXPECT_EQ(run.blocked_cycles, 0);
    EXPECT_GT(run.max_force_n, 0.1) << "the walls were felt";
    EXPECT_GT(run.max_torque_nm, 1e-3);
  }
}

TEST(Assembly, ASlowPoseAndADeviceWithoutTorqueAreGoodEnough) {
  const AssemblyRun slow = put_peg_into(0.026, true, 10);
  EXPECT_LT(slow.grip_points.back().z(), -0.006);
  EXPECT_EQ(slow.penetrations, 0);
  const AssemblyRun without_torque = put_peg_into(0.026, false, 1);
  EXPECT_LT(without_torque.grip_points.back().z(), -0.006)
      << "the hand of a device without torque holds its tilt: the peg turns, the stylus does not";
  EXPECT_EQ(without_torque.max_torque_nm, 0.0);
  EXPECT_EQ(without_torque.penetrations, 0);
}

// The paths that are delivered with the scenes, for a first try without a device.
struct ReadyPath {
  std::string name;
  double in_place_s = 0.0;  // the time at which the tool is in its place
  int axis = 2;
  double low_m = 0.0, high_m = 0.0;  // the tool's position along `axis` is between these
};

TEST(Assembly, TheReadyPathsPutTheToolInItsPlace) {
  for (const ReadyPath& ready : {ReadyPath{"pegs", 4.5, 2, -0.0085, -0.0075}, ReadyPath{"assembly", 4.0, 2, -0.0117, -0.0113},
                                 ReadyPath{"wing_nut", 21.5, 1, 0.0138, 0.0141}}) {
    SCOPED_TRACE(ready.name);
    const auto path = read_trajectory_csv(HAPTON_SOURCE_DIR "/scenes/paths/" + ready.name + ".csv");
    ASSERT_TRUE(path) << path.error().what;
    const AssemblyRun run = follow_path(ready.name, *path, true, 2);
    const auto cycle = static_cast<std::size_t>(1000.0 * ready.in_place_s);
    ASSERT_GT(run.grip_points.size(), cycle);
    EXPECT_GT(run.grip_points[cycle][ready.axis], ready.low_m);
    EXPECT_LT(run.grip_points[cycle][ready.axis], ready.high_m);
    EXPECT_EQ(run.penetrations, 0);
    EXPECT_EQ(run.blocked_cycles, 0);
    EXPECT_GT(run.max_force_n, 0.1) << "it was felt";
    EXPECT_GT(run.max_torque_nm, 1e-3);
  }
}

// The path for the workbench has to pick up the peg, which needs real programs: deploy/run --scene scenes/workbench.toml --trajectory.
TEST(Assembly, EachReadyPathIsOfAScene) {
  int path_count = 0;
  for (const auto& file : std::filesystem::directory_iterator(HAPTON_SOURCE_DIR "/scenes/paths")) {
    ++path_count;
    const auto path = read_trajectory_csv(file.path().string());
    ASSERT_TRUE(path) << path.error().what;
    EXPECT_TRUE(path->front().has_turn);
    const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/" + file.path().stem().string() + ".toml");
    ASSERT_TRUE(scene) << scene.error().what;
    const bool presses_button = std::any_of(path->begin(), path->end(), [](const TrajectoryRow& row) { return row.buttons != 0; });
    EXPECT_EQ(presses_button, !scene->tool) << file.path();
  }
  EXPECT_EQ(path_count, 4);
}

TEST(Assembly, ThePartOfTheNistAssemblyIsAToolToo) {
  const auto scene = load_scene(HAPTON_SOURCE_DIR "/scenes/assembly.toml");
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_TRUE(scene->tool);
  EXPECT_EQ(scene->tool->name, "screen");
}

}  // namespace
}  // namespace hapton
