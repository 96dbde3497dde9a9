#include "bench/measure/converged_steps.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "core/force/reference/reference_method.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

using SwitchCause = BranchSwitch::Cause;

constexpr std::size_t kStartStep = 3;
constexpr int kStepsFromJump = 12;

MethodSettings settings_for(const char* name) {
  MethodSettings settings;
  settings.name = name;
  return settings;
}

// A strip of 100 mm along x and 20 mm along y in z = 0, of 2 * cells triangles.
TouchScene strip_of(std::uint32_t cells, const Material& material = {}) {
  auto mesh = std::make_shared<TriangleMesh>();
  for (std::uint32_t i = 0; i <= cells; ++i) {
    for (const double y : {-0.01, 0.01}) mesh->vertices.emplace_back(0.1 * i / cells - 0.05, y, 0.0);
  }
  for (std::uint32_t i = 0; i < cells; ++i) {
    const std::uint32_t a = 2 * i;
    mesh->triangles.push_back({a, a + 2, a + 3});
    mesh->triangles.push_back({a, a + 3, a + 1});
  }
  TouchScene scene;
  scene.objects.push_back({mesh, material});
  return scene;
}

// The device goes down onto the strip at x = -40 mm, makes two short steps, then one of `distance_m` along the strip, and 11 short ones.
TouchTrajectory jump_trajectory(double distance_m) {
  TouchTrajectory trajectory;
  trajectory.p_SD = {Vec3(-0.04, 0.003, 1e-3), Vec3(-0.04, 0.003, -1e-3), Vec3(-0.0399, 0.003, -1e-3), Vec3(-0.0398, 0.003, -1e-3)};
  for (int i = 0; i < kStepsFromJump; ++i) trajectory.p_SD.emplace_back(-0.0398 + distance_m + 1e-4 * i, 0.003, -1e-3);
  return trajectory;
}

ForceError compare(const TouchScene& scene, const TouchTrajectory& trajectory) {
  const std::size_t count = trajectory.p_SD.size() - kStartStep - 1;
  const std::vector<ForceSample> proxy_steps = compute_forces(settings_for("proxy"), scene, trajectory).value();
  auto converged = ConvergedSteps::make(settings_for("proxy"), scene).value().compute(trajectory, kStartStep, count).felt;
  auto reference = ReferenceMethod::make_reference(settings_for("reference"), scene).value();
  reference->continue_from(proxy_steps[kStartStep].proxy, proxy_steps[kStartStep].device, true);
  std::vector<ForceSample> method(proxy_steps.begin() + kStartStep + 1, proxy_steps.end()), expected;
  for (const ForceSample& step : method) {
    const MethodOutput output = reference->step({.p_SD = step.device});
    expected.push_back({step.device, output.p_SP, output.force_n, reference->last_step().settled});
  }
  const ForceError converged_error = compare_forces(converged, expected, {}, converged);
  EXPECT_EQ(converged_error.branch_switches, 0u);
  EXPECT_LT(converged_error.error.most, 1e-6);
  return compare_forces(method, expected, {}, converged);
}

TEST(ConvergedSteps, AJumpLongerThanTheWorkLimitIsAnUnconvergedSwitch) {
  const ForceError error = compare(strip_of(1200), jump_trajectory(0.079));  // over 1,900 triangles, of which a step crosses about 500
  EXPECT_EQ(error.branch_switches, 1u);
  EXPECT_EQ(error.count(SwitchCause::unconverged), 1u);
  EXPECT_GT(error.error.most, 1.0);
  EXPECT_LT(error.switched_steps, std::size_t{kStepsFromJump});
}

TEST(ConvergedSteps, AShortMotionIsNoSwitch) {
  const ForceError error = compare(strip_of(50), jump_trajectory(0.02));
  EXPECT_EQ(error.branch_switches, 0u);
}

// The device starts below the strip, so the method does not touch it. The converged steps do not reach the minimum of the reference either,
// so the switch does not count as unconverged.
TEST(ConvergedSteps, AnotherBranchIsNotUnconverged) {
  const TouchScene scene = strip_of(1200);
  TouchTrajectory trajectory = jump_trajectory(0.079);
  const std::size_t count = trajectory.p_SD.size() - kStartStep - 1;
  auto reference = compute_forces(settings_for("reference"), scene, trajectory).value();
  trajectory.p_SD[0].z() = trajectory.p_SD[1].z();
  const std::vector<ForceSample> proxy_steps = compute_forces(settings_for("proxy"), scene, trajectory).value();
  const auto converged = ConvergedSteps::make(settings_for("proxy"), scene).value().compute(trajectory, kStartStep, count).felt;
  const std::vector<ForceSample> method(proxy_steps.begin() + kStartStep + 1, proxy_steps.end());
  reference.erase(reference.begin(), reference.begin() + kStartStep + 1);
  const ForceError error = compare_forces(method, reference, {}, converged);
  EXPECT_EQ(error.branch_switches, 1u);
  EXPECT_EQ(error.switched_steps, std::size_t{kStepsFromJump});
  EXPECT_EQ(error.count(SwitchCause::unconverged), 0u);
  EXPECT_EQ(error.count(SwitchCause::unexplained), 1u);
}

TEST(ConvergedSteps, IsTheMethodItselfWhereNothingIsCarried) {
  TouchScene scene;
  auto mesh = std::make_shared<TriangleMesh>(make_bumpy_sphere(0.045, 0.2, 1000, 3));
  auto trajectory = make_slide_trajectory(*mesh, {.seed = 1, .rows = 8000, .rate_hz = 1000.0}).value();
  ASSERT_GT(trajectory.reset_every, 0u);
  scene.objects.push_back({mesh, Material{.friction_static = 0.5, .friction_dynamic = 0.4}});
  const std::vector<ForceSample> proxy_steps = compute_forces(settings_for("proxy"), scene, trajectory).value();
  ConvergedSteps steps = ConvergedSteps::make(settings_for("proxy"), scene).value();
  for (const std::size_t start : {std::size_t{700}, trajectory.reset_every + 900, std::size_t{300}}) {
    const std::vector<ForceSample> converged = steps.compute(trajectory, start, 40).felt;
    ASSERT_EQ(converged.size(), 40u);
    for (std::size_t i = 0; i < 40; ++i) {
      EXPECT_EQ(converged[i].force_n, proxy_steps[start + 1 + i].force_n);
      EXPECT_EQ(converged[i].proxy, proxy_steps[start + 1 + i].proxy);
    }
  }
}

// The proxy slides, stops as the pressure grows, and sticks when its pull has fallen to less than half the dynamic cone.
TEST(ConvergedSteps, TellWhetherTheWindowBeginsSliding) {
  ConvergedSteps steps =
      ConvergedSteps::make(settings_for("proxy"), strip_of(50, {.friction_static = 0.5, .friction_dynamic = 0.4})).value();
  TouchTrajectory trajectory;
  for (int i = 0; i < 20; ++i) trajectory.p_SD.emplace_back(1e-4 * i, 0.0, i == 0 ? 1e-3 : -1e-3);
  for (int i = 0; i < 4; ++i) trajectory.p_SD.emplace_back(2e-3, 0.0, -1e-3 * (i + 1));
  EXPECT_FALSE(steps.compute(trajectory, 0, 1).begins_sliding);  // free
  EXPECT_FALSE(steps.compute(trajectory, 3, 1).begins_sliding);  // the pull is 0.3 of the pressure
  EXPECT_TRUE(steps.compute(trajectory, 10, 1).begins_sliding);
  EXPECT_TRUE(steps.compute(trajectory, 19, 1).begins_sliding);
  EXPECT_FALSE(steps.compute(trajectory, 22, 1).begins_sliding);  // the pull is 0.4 of a third of the pressure
}

TEST(ConvergedSteps, AWindowMayBeginWithACarriedStep) {
  const TouchScene scene = strip_of(1200);
  const TouchTrajectory trajectory = jump_trajectory(0.079);
  const std::size_t jump = kStartStep + 1;
  const std::vector<ForceSample> proxy_steps = compute_forces(settings_for("proxy"), scene, trajectory).value();
  ConvergedSteps steps = ConvergedSteps::make(settings_for("proxy"), scene).value();
  EXPECT_EQ(steps.compute(trajectory, kStartStep, 1).begins_at, proxy_steps[kStartStep].device);
  const ConvergedSteps::Window window = steps.compute(trajectory, jump, 4);
  EXPECT_GT(window.begins_at.x(), proxy_steps[kStartStep].device.x() + 0.01);
  EXPECT_LT(window.begins_at.x(), proxy_steps[jump].device.x() - 0.01);
  EXPECT_NEAR(window.begins_at.x(), proxy_steps[jump].proxy.x(), 1e-4);  // over the plane the proxy is above the device
}

TEST(ConvergedSteps, AMethodThatCannotBeMadeIsAnError) {
  EXPECT_FALSE(ConvergedSteps::make(settings_for("none"), strip_of(2)).has_value());
}

}  // namespace
}  // namespace hapton
