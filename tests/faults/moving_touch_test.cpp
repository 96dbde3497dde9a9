// A scene that moves, felt from patches of its bodies across a slow and a bad network. Times are simulated; only the threads that send and
// build patches run in real time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/math/commanded_motion.h"
#include "scene/commanded_object.h"
#include "scene/object_reader.h"
#include "tests/faults/simulated_system.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr double kBoxTopM = 0.05;
constexpr double kBoxStiffness = 1000.0;
// The rounding of vertices to a patch's grid, as a force.
constexpr double kGridForceN = 1e-4;

// The box that PressingDevice presses 2 mm deep.
SceneObject pressed_box() {
  SceneObject box;
  box.name = "box";
  box.mesh = made::shared(made::box(Vec3::Constant(-kBoxTopM), Vec3::Constant(kBoxTopM)));
  return box;
}

// A box that moves up and down by a millimetre, again and again.
Scene rocking_box() {
  Scene scene;
  scene.objects.push_back(pressed_box());
  scene.objects[0].motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(),
      std::vector<Keyframe>{
          {0.0, Vec3::Zero(), Quat::Identity()}, {0.2, Vec3(0, 0, 0.001), Quat::Identity()}, {0.5, Vec3::Zero(), Quat::Identity()}},
      true);
  return scene;
}

Scene commanded_box() {
  Scene scene;
  scene.objects.push_back(pressed_box());
  ObjectSpec spec;
  spec.motion.by_program = true;
  scene.objects[0].commanded = std::make_shared<const CommandedObject>(spec, SceneFit(), *scene.objects[0].mesh);
  return scene;
}

// Sets a delay of 30 ms in each direction: the hub uses no remote force.
void set_far_link(SimulatedSystem& system, double loss = 0.0) {
  const LinkFaults faults{.delay_ns = 30 * kMs, .jitter_ns = loss > 0.0 ? 10 * kMs : 0, .loss = loss};
  system.set_faults(faults, faults);
}

// The hand presses in while the haptics node is near, and stays when the node becomes far: a hand that begins inside gets no force.
void press_in_then_set_far(SimulatedSystem& system, double loss = 0.0) {
  system.start_haptics();
  system.run_for_ns(500 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  set_far_link(system, loss);
  system.run_for_ns(300 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  system.local_steps.clear();
}

double spring_n(double top_m, const SimulatedSystem::LocalStep& step) {
  return kBoxStiffness * std::max(0.0, top_m - step.sample.p_WD.z());
}

// Expects that the surface under the hand, which holds still, moves no faster than kMaxSurfaceSpeed.
void expect_no_jump(const SimulatedSystem& system) {
  ASSERT_GT(system.local_steps.size(), 1000U);
  for (std::size_t n = 1; n < system.local_steps.size(); ++n) {
    const std::int64_t passed_ns = system.local_steps[n].sample.time_ns - system.local_steps[n - 1].sample.time_ns;
    if (passed_ns > 2 * kMs) continue;  // the hub had not heard from the haptics node for a second
    const double most_n = kBoxStiffness * kMaxSurfaceSpeed * 1e-9 * static_cast<double>(passed_ns);
    ASSERT_LE(std::abs(system.local_steps[n].force.force_n.z() - system.local_steps[n - 1].force.force_n.z()), most_n + 1e-6) << n;
  }
}

// The force of each sample is that of the box at the scene time of the sample, and the haptics node has the same scene time for it.
TEST(MovingTouch, HubAndHapticsNodeHaveTheObjectAtOnePlace) {
  SimulatedSystem system(3, TouchChoice::patch);
  system.scene = rocking_box();
  press_in_then_set_far(system);
  const KeyframeMotion& motion = *system.scene.objects[0].motion;
  for (int n = 0; n < 20; ++n) {
    system.run_for_ns(97 * kMs);
    // The node has the scene time of a sample that the hub sent up to 50 ms, plus half a round trip, ago.
    const auto known = std::find_if(system.local_steps.begin(), system.local_steps.end(), [&](const SimulatedSystem::LocalStep& one) {
      return one.force.scene_time_ns == system.haptics->scene_time_ns();
    });
    ASSERT_NE(known, system.local_steps.end()) << n;
    EXPECT_LE(system.clock.now_ns() - known->sample.time_ns, 90 * kMs);
  }
  ASSERT_GT(system.local_steps.size(), 1900U);
  double least_n = 1e9;
  double most_n = 0.0;
  for (std::size_t n = 1; n < system.local_steps.size(); ++n) {
    const SimulatedSystem::LocalStep& one = system.local_steps[n];
    const std::int64_t passed_ns = one.sample.time_ns - system.local_steps[n - 1].sample.time_ns;
    ASSERT_EQ(one.force.scene_time_ns - system.local_steps[n - 1].force.scene_time_ns, passed_ns);
    const double top_m = kBoxTopM + motion.pose_at(1e-9 * static_cast<double>(one.force.scene_time_ns)).translation().z();
    ASSERT_NEAR(one.force.force_n.z(), spring_n(top_m, one), kGridForceN) << n;
    least_n = std::min(least_n, one.force.force_n.z());
    most_n = std::max(most_n, one.force.force_n.z());
  }
  EXPECT_LT(least_n, 2.05);
  EXPECT_GT(most_n, 2.95);
}

// A program's move is announced before it begins, so both sides have the same move at exactly the same scene time.
TEST(MovingTouch, AProgramsMoveIsFeltAsItWasAnnounced) {
  SimulatedSystem system(4, TouchChoice::patch);
  system.scene = commanded_box();
  press_in_then_set_far(system);
  for (std::uint32_t request = 1; request <= 5; ++request) {
    system.haptics->mover.request(
        {.request = request, .object = {"box"}, .p_m = Vec3(0, 0, request % 2 == 1 ? 0.001 : 0.0), .over_s = 0.05});
    system.run_for_ns(400 * kMs);
  }
  EXPECT_EQ(system.stats().patch_touch.late_moves, 0U);
  const CommandedMotion* motion = system.haptics->touch().find_commanded(0);
  ASSERT_NE(motion, nullptr);
  EXPECT_EQ(motion->newest().serial, 5U);
  double most_n = 0.0;
  for (const SimulatedSystem::LocalStep& one : system.local_steps) {
    const double top_m = kBoxTopM + motion->pose_at(1e-9 * static_cast<double>(one.force.scene_time_ns)).translation().z();
    ASSERT_NEAR(one.force.force_n.z(), spring_n(top_m, one), kGridForceN);
    most_n = std::max(most_n, one.force.force_n.z());
  }
  EXPECT_GT(most_n, 2.95);
}

// A third of all datagrams is lost, and the rest overtake each other: the surface never jumps, and is where the haptics node has it once it
// is at rest.
TEST(MovingTouch, LostMovesDoNotMakeTheSurfaceJump) {
  SimulatedSystem system(5, TouchChoice::patch);
  system.scene = commanded_box();
  press_in_then_set_far(system, 0.33);
  for (std::uint32_t request = 1; request <= 20; ++request) {
    system.haptics->mover.request(
        {.request = request, .object = {"box"}, .p_m = Vec3(0, 0, 0.0005 * static_cast<double>(request % 3)), .over_s = 0.02});
    system.run_for_ns(150 * kMs);
  }
  system.run_for_ns(2000 * kMs);
  ASSERT_NO_FATAL_FAILURE(expect_no_jump(system));
  const CommandedMotion* motion = system.haptics->touch().find_commanded(0);
  const double top_m = kBoxTopM + motion->newest().to.p_S.z();
  EXPECT_NEAR(system.local_steps.back().force.force_n.z(), spring_n(top_m, system.local_steps.back()), kGridForceN);
}

// A box whose top a program raises and lowers.
Scene swelling_box() {
  Scene scene;
  scene.objects.push_back(pressed_box());
  scene.objects[0].program_shape = std::make_shared<const ProgramShape>(ProgramShape{.reach_m = 0.002});
  return scene;
}

std::vector<ShapePart::Displacement> raised_top(const TriangleMesh& box, double by_m) {
  std::vector<ShapePart::Displacement> shape;
  for (const Vec3& p : box.vertices) shape.push_back({0.0F, 0.0F, p.z() > 0.0 ? static_cast<float>(by_m) : 0.0F});
  return shape;
}

// Runs until the haptics node has announced this many shapes. False: it does not.
bool wait_for_shape(SimulatedSystem& system, std::uint64_t shape_count) {
  for (int n = 0; n < 3000 && system.haptics->shaper().counts().shapes < shape_count; ++n) {
    system.run_for_ns(2 * kMs);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return system.haptics->shaper().counts().shapes >= shape_count;
}

// Runs with pauses in real time, for the threads that prepare shapes.
void run_beside_builders(SimulatedSystem& system, int tens_of_ms) {
  for (int n = 0; n < tens_of_ms; ++n) {
    system.run_for_ns(10 * kMs);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

// A program's shape is announced before it begins, so both sides have the same shape at exactly the same scene time.
TEST(MovingTouch, AProgramsShapeIsFeltAsItWasAnnounced) {
  SimulatedSystem system(8, TouchChoice::patch);
  system.scene = swelling_box();
  press_in_then_set_far(system);
  system.run_for_ns(4000 * kMs);  // until the median round trip is that of the far node
  system.local_steps.clear();
  std::vector<std::pair<ShapeStart, double>> starts = {{ShapeStart(), 0.0}};
  for (std::uint32_t shape = 1; shape <= 6; ++shape) {
    const double by_m = 0.0005 * static_cast<double>(shape % 3);
    system.haptics->deform(shape, raised_top(*system.scene.objects[0].mesh, by_m), 0.05);
    ASSERT_TRUE(wait_for_shape(system, shape));
    starts.emplace_back(*system.haptics->shaper().newest(), by_m);
    run_beside_builders(system, 15);
  }
  run_beside_builders(system, 50);
  EXPECT_EQ(system.stats().patch_touch.shapes, 6U);
  EXPECT_EQ(system.stats().patch_touch.late_shapes, 0U);
  const auto top_at = [&](std::int64_t scene_ns) {
    double top_m = kBoxTopM;
    for (std::size_t n = 1; n < starts.size(); ++n) {
      const auto& [start, by_m] = starts[n];
      const double share = static_cast<double>(scene_ns - start.start_ns) / static_cast<double>(start.end_ns - start.start_ns);
      if (share > 0.0) top_m = kBoxTopM + starts[n - 1].second + std::min(share, 1.0) * (by_m - starts[n - 1].second);
    }
    return top_m;
  };
  double most_n = 0.0;
  for (const SimulatedSystem::LocalStep& one : system.local_steps) {
    ASSERT_NEAR(one.force.force_n.z(), spring_n(top_at(one.force.scene_time_ns), one), kGridForceN);
    most_n = std::max(most_n, one.force.force_n.z());
  }
  EXPECT_GT(most_n, 2.95);
}

// A third of all datagrams is lost, and the rest overtake each other, while shapes come without pause.
TEST(MovingTouch, LostShapesDoNotMakeTheSurfaceJump) {
  SimulatedSystem system(9, TouchChoice::patch);
  system.scene = swelling_box();
  press_in_then_set_far(system, 0.33);
  double by_m = 0.0;
  for (std::uint32_t shape = 1; shape <= 40; ++shape) {
    by_m = 0.0005 * static_cast<double>(shape % 4);
    system.haptics->deform(shape, raised_top(*system.scene.objects[0].mesh, by_m), 0.03);
    run_beside_builders(system, 4);
  }
  by_m = 0.0015;
  system.haptics->deform(41, raised_top(*system.scene.objects[0].mesh, by_m), 0.03);
  const auto is_there = [&] {
    const SimulatedSystem::LocalStep& last = system.local_steps.back();
    return std::abs(last.force.force_n.z() - spring_n(kBoxTopM + by_m, last)) < kGridForceN;
  };
  for (int n = 0; n < 5000 && (n < 100 || !is_there()); ++n) {
    system.run_for_ns(20 * kMs);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_TRUE(is_there()) << system.local_steps.back().force.force_n.z();
  EXPECT_GT(system.stats().patch_touch.shapes, 5U);
  ASSERT_NO_FATAL_FAILURE(expect_no_jump(system));
}

// The source changes from patches to remote force while the box moves: no force discontinuity, and at the end all force is remote.
TEST(MovingTouch, TheForceHasNoJumpWhereTheSourceChanges) {
  SimulatedSystem system(6, TouchChoice::automatic);
  system.scene = rocking_box();
  const LinkFaults slow{.delay_ns = 6 * kMs};
  system.set_faults(slow, slow);
  system.start_haptics();
  system.run_for_ns(1500 * kMs);
  ASSERT_TRUE(system.wait_for_patches());
  const std::size_t first = system.device.written.size();
  system.run_for_ns(1000 * kMs);
  system.set_faults({}, {});
  system.run_for_ns(6000 * kMs);
  const std::uint64_t local = system.stats().local_forces;
  system.run_for_ns(500 * kMs);
  EXPECT_EQ(system.stats().local_forces, local) << "remote again";
  double largest_slew_n_per_s = 0.0;
  double least_n = 1e9;
  for (std::size_t n = first + 1; n < system.device.written.size(); ++n) {
    const auto& [force_n, time_ns] = system.device.written[n];
    const double passed_s = std::max(1e-3, 1e-9 * static_cast<double>(time_ns - system.device.written[n - 1].time_ns));
    largest_slew_n_per_s = std::max(largest_slew_n_per_s, (force_n - system.device.written[n - 1].force_n).norm() / passed_s);
    least_n = std::min(least_n, force_n.z());
  }
  // The box moves with 5 mm/s at most; the remote force is 12 ms late at first, so that up to 0.06 N fade over 0.1 s.
  EXPECT_LT(largest_slew_n_per_s, kBoxStiffness * 0.005 + 4.0);
  EXPECT_GT(least_n, 1.8);
}

// After a request like that of `hapton set`, the force of the hub fades to the new stiffness, as when its source changes.
TEST(MovingTouch, OtherMaterialsFadeInWhileTheHubComputesTheForce) {
  SimulatedSystem system(7, TouchChoice::patch);
  press_in_then_set_far(system);
  system.run_for_ns(500 * kMs);
  EXPECT_NEAR(system.force_n().z(), 2.0, 0.01);
  const std::size_t first = system.device.written.size();
  system.haptics->set_materials({{.stiffness_n_per_m = 500.0}});
  for (int n = 0; n < 3000 && std::abs(system.force_n().z() - 1.0) > 0.01; ++n) {
    system.run_for_ns(2 * kMs);
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  EXPECT_NEAR(system.force_n().z(), 1.0, 0.01);
  double largest_step_n = 0.0;
  for (std::size_t n = first + 1; n < system.device.written.size(); ++n) {
    largest_step_n = std::max(largest_step_n, (system.device.written[n].force_n - system.device.written[n - 1].force_n).norm());
  }
  EXPECT_LT(largest_step_n, 0.03) << "1 N over 0.1 s";
}

}  // namespace
}  // namespace hapton
