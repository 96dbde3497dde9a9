#include "bench/measure/gear_scenario.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/tool/penetration_check.h"

namespace hapton {
namespace {

TEST(GearScenario, TheGapsSlopeIsItsDerivative) {
  const SpurGear gear;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int n = 0; n < 200; ++n) {
    const Vec3 at(0.0403 + 2e-4 * unit(random), 2e-4 * unit(random), 0.01 * unit(random));
    for (const bool ccw : {false, true}) {
      Vec3 slope;
      (void)find_flank_gap(gear, at.head<2>(), at.z(), ccw, &slope);
      for (int i = 0; i < 3; ++i) {
        const Vec3 step = 1e-7 * Vec3::Unit(i);
        const double numeric_slope = (find_flank_gap(gear, (at + step).head<2>(), (at + step).z(), ccw) -
                                      find_flank_gap(gear, (at - step).head<2>(), (at - step).z(), ccw)) /
                                     2e-7;
        EXPECT_NEAR(numeric_slope, slope[i], 1e-5) << "seed 3, axis " << i;
      }
    }
  }
}

// The formula against the meshes: where both gaps are open by a micrometre the gears do not intersect, and where one is closed by three
// micrometres (more than the flanks' facets lie within the involute) they do.
TEST(GearScenario, TheGapIsThatOfTheMeshes) {
  const SixdofScenario made = make_gear_scenario(10);
  auto step = ToolStep::make(*made.tool, {made.scene}, made.coupling);
  ASSERT_TRUE(step);
  PenetrationCheck check((*step)->tool(), (*step)->scene());
  const SpurGear gear;
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  int open = 0;
  int closed = 0;
  for (int n = 0; n < 300; ++n) {
    const Vec3 at(0.0403 + 2e-4 * unit(random), 2e-4 * unit(random), 0.008 * unit(random));
    const double least_gap = std::min(find_flank_gap(gear, at.head<2>(), at.z(), true), find_flank_gap(gear, at.head<2>(), at.z(), false));
    ToolInput input;
    input.X_WD.translation() = Vec3(at.x(), at.y(), 0.0005);
    input.X_WD.linear() = turn_by({0.0, 0.0, at.z()}).toRotationMatrix();
    const bool penetrates = check.penetrates((*step)->to_local(input));
    if (least_gap > 1e-6) {
      EXPECT_FALSE(penetrates) << at.transpose() << " gap " << least_gap;
      ++open;
    }
    if (least_gap < -3e-6) {
      EXPECT_TRUE(penetrates) << at.transpose() << " gap " << least_gap;
      ++closed;
    }
  }
  EXPECT_GT(open, 20);
  EXPECT_GT(closed, 20);
}

// Over a closed path in x, y and the turn, contact does no work.
TEST(GearScenario, TheExpectedWrenchIsConservative) {
  const SixdofScenario made = make_gear_scenario(10);
  double work = 0.0;
  double size = 0.0;
  constexpr int kParts = 5000;
  const auto at = [](int n) {
    const double angle = 2.0 * 3.14159265358979 * n / kParts;
    Pose X = Pose::Identity();
    X.translation() = Vec3(0.0402 + 2e-4 * std::cos(angle), 2e-4 * std::sin(2.0 * angle), 0.0);
    X.linear() = turn_by({0.0, 0.0, 0.04 + 0.02 * std::sin(angle)}).toRotationMatrix();
    return X;
  };
  for (int n = 0; n < kParts; ++n) {
    const Wrench6 a = made.expected(at(n));
    const Wrench6 b = made.expected(at(n + 1));
    const double turn = turn_between(Quat(at(n).linear()), Quat(at(n + 1).linear())).z();
    const double part =
        0.5 * (a.force_n + b.force_n).dot(at(n + 1).translation() - at(n).translation()) + 0.5 * (a.torque_nm + b.torque_nm).z() * turn;
    work += part;
    size += std::fabs(part);
  }
  EXPECT_GT(size, 0.0);
  EXPECT_LE(std::fabs(work), 1e-3 * size);
}

}  // namespace
}  // namespace hapton
