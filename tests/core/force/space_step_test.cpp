#include "core/force/space_step.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

std::vector<SwitchedEffect> some_effects() {
  return {SpringEffect{.centre = {0.01, 0.02, 0.0}, .stiffness_n_per_m = 40.0}, ViscousEffect{.damping_ns_per_m = 3.0}, WaveEffect{},
          MassEffect{}};
}

Pose turned_scene() {
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix();
  X_WS.translation() = Vec3(0.5, 0.01, -0.02);
  return X_WS;
}

// The same force is computed in three ways: without a method, by TouchStep beside a tool, and by TouchStep in free space.
TEST(SpaceStep, IsWhatAProbeFeelsInFreeSpaceWhileTheSceneTurns) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.01, -5.0, 2)), {}}}, .effects = some_effects()};
  SpaceStep without_method(some_effects());
  TouchStep beside_tool(*make_method({.name = "proxy"}, scene), scene);
  TouchStep probe(*make_method({.name = "proxy"}, scene), scene);
  TouchInput input{.p_WD = {0.0, 0.0, 0.05}};
  beside_tool.reset_effects(input);
  probe.reset(input);
  const AllocationGuard guard;
  for (int n = 0; n < 200; ++n) {
    input.p_WD = {0.001 * n, 0.01 * std::sin(0.05 * n), 0.05};
    if (n == 100) input.X_WS = turned_scene();
    const Vec3 expected = probe.step(input).force_n;
    ASSERT_LT((without_method.step(input) - expected).norm(), 1e-9) << n;
    ASSERT_EQ(beside_tool.step_in_space(input), expected) << n;
    ASSERT_GT(expected.norm(), 0.1);
  }
  EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
}

TEST(SpaceStep, BeginsAnewAtAReset) {
  SpaceStep step(some_effects());
  std::vector<Vec3> first;
  for (int run = 0; run < 2; ++run) {
    step.reset();
    for (int n = 0; n < 100; ++n) {
      const Vec3 felt = step.step({.p_WD = {0.001 * n, 0.0, 0.01}});
      if (run == 0) first.push_back(felt);
      EXPECT_EQ(felt, first[static_cast<std::size_t>(n)]) << n;
    }
  }
}

TEST(SpaceStep, ASampleThatIsNotFiniteChangesNothing) {
  SpaceStep step(some_effects());
  SpaceStep without_it(some_effects());
  TouchInput input;
  const auto take_bad_sample = [&] {
    EXPECT_EQ(step.step({.p_WD = Vec3::Constant(std::numeric_limits<double>::quiet_NaN()), .X_WS = input.X_WS}), Vec3::Zero());
  };
  for (int n = 0; n < 150; ++n) {
    // One just before the scene turns, and one just after it has turned back, the first sample there.
    if (n == 50) {
      take_bad_sample();
      input.X_WS = turned_scene();
    }
    if (n == 100) {
      input.X_WS = Pose::Identity();
      take_bad_sample();
    }
    input.p_WD = {0.001 * n, 0.01 * std::sin(0.05 * n), 0.05};
    const Vec3 expected = without_it.step(input);
    ASSERT_EQ(step.step(input), expected) << n;
    ASSERT_GT(expected.norm(), 0.1);
  }
}

TEST(SpaceStep, ATurnOfTheSceneIsNoVelocityOfAHandAtRest) {
  SpaceStep step({ViscousEffect{.damping_ns_per_m = 5.0}});
  TouchInput input{.p_WD = {0.05, 0.001, 0.02}};
  for (int n = 0; n < 20; ++n) (void)step.step(input);
  input.X_WS = turned_scene();
  for (int n = 0; n < 20; ++n) EXPECT_LT(step.step(input).norm(), 1e-9) << n;
}

TEST(SpaceStep, ASceneWithoutEffectsGivesNoForce) {
  const TouchScene scene = {.objects = {{made::shared(made::sheet(0.1, 0.0, 2)), {}}}};
  TouchStep touch(*make_method({.name = "proxy"}, scene), scene);
  EXPECT_EQ(touch.step_in_space({.p_WD = {0.0, 0.0, -0.01}}), Vec3::Zero());
}

}  // namespace
}  // namespace hapton
