#include "bench/measure/sixdof_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// The expected wrench of each scenario is minus the gradient of the least energy over the poses that the tool may take. So its work along
// any motion of the device is the change of that energy: over a closed loop none.
TEST(SixdofScenes, ExpectedWrenchesAreConservative) {
  for (const SixdofScenario& scenario : make_analytic_scenarios(400)) {
    ASSERT_TRUE(scenario.expected) << scenario.name;
    const Pose middle = *std::max_element(scenario.device.begin(), scenario.device.end(), [&](const Pose& a, const Pose& b) {
      return scenario.expected(a).force_n.norm() < scenario.expected(b).force_n.norm();
    });
    double work = 0.0;
    double size = 0.0;
    constexpr int kParts = 20'000;
    const auto pose_at = [&](int n) {
      const double angle = 2.0 * 3.14159265358979 * n / kParts;
      Pose X = middle;
      X.translation() += 5e-4 * Vec3(std::cos(angle), std::sin(2.0 * angle), std::sin(angle));
      X.linear() = turn_by({0.0, 0.02 * std::sin(angle + 0.4), 0.0}).toRotationMatrix() * middle.linear();
      return X;
    };
    for (int n = 0; n < kParts; ++n) {
      const Pose from = pose_at(n);
      const Pose to = pose_at(n + 1);
      const Wrench6 a = scenario.expected(from);
      const Wrench6 b = scenario.expected(to);
      const Vec3 turn = turn_between(Quat(from.linear()), Quat(to.linear()));
      const double part =
          0.5 * (a.force_n + b.force_n).dot(to.translation() - from.translation()) + 0.5 * (a.torque_nm + b.torque_nm).dot(turn);
      work += part;
      size += std::fabs(part);
    }
    EXPECT_GT(size, 0.0) << scenario.name;
    EXPECT_LE(std::fabs(work), 1e-3 * size) << scenario.name;
  }
}

TEST(SixdofScenes, EveryMotionBeginsInFreeSpaceAndPresses) {
  std::vector<SixdofScenario> scenarios = make_analytic_scenarios(500);
  scenarios.push_back(make_peg_scenario(1500, 3));
  scenarios.push_back(make_size_scenario(500, 2000, 1000, 3));
  for (const SixdofScenario& scenario : scenarios) {
    auto step = ToolStep::make(*scenario.tool, {scenario.scene}, scenario.coupling);
    ASSERT_TRUE(step) << scenario.name;
    (*step)->reset({scenario.device.front()});
    int contact_steps = 0;
    for (std::size_t i = 0; i < scenario.device.size(); ++i) {
      const ToolOutput out = (*step)->step({scenario.device[i]});
      ASSERT_FALSE(out.proxy.is_blocked) << scenario.name << " at " << i;
      contact_steps += out.contact ? 1 : 0;
    }
    EXPECT_GT(contact_steps, 100) << scenario.name;
  }
}

TEST(SixdofScenes, SizesAreAboutThoseRequested) {
  const SixdofScenario made = make_size_scenario(1000, 5000, 10, 1);
  EXPECT_GE(made.tool->triangles.size(), 1000U);
  EXPECT_GE(made.scene->triangles.size(), 5000U);
  EXPECT_LE(made.scene->triangles.size(), 20'000U);
}

}  // namespace
}  // namespace hapton
