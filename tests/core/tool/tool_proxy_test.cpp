#include "core/tool/tool_proxy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/penetration_check.h"
#include "tests/core/tool/random_vector.h"

namespace hapton {
namespace {

class ToolProxyTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 11;
  static constexpr double kTurnLength = 0.2;
  std::mt19937_64 random{kSeed};
  std::uniform_real_distribution<double> uniform{-1.0, 1.0};
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.2, 1000, 5);
  const TouchGeometry scene{std::vector<const TriangleMesh*>{&ball}};
  const ObjectGeometry tool{make_box({0.1, 0.2, 0.15}, 2), {Vec3::Zero(), scene.unit_m()}};
  ToolProxy proxy{tool, scene, kTurnLength};
  PenetrationCheck check{tool, scene};

  Vec3 draw() { return {uniform(random), uniform(random), uniform(random)}; }
  static double energy(const Placement& a, const Placement& b) {
    return (a.position - b.position).squaredNorm() + std::pow(kTurnLength * turn_between(a.orientation, b.orientation).norm(), 2);
  }
  double least_gap(const Placement& at) {
    NearFeatures near(tool, scene);
    double least = 1e300;
    if (!near.collect(at, 4.0 * ToolProxy::kContactOffset, 0.0)) return 0.0;
    for (const NearFeature& feature : near.features()) least = std::min(least, feature.gap.distance);
    return least;
  }
};

// Random motions press and turn the tool: it keeps its gap in every step, and where the proxy has converged, no small motion that keeps
// the contact offset comes nearer to the device.
TEST_F(ToolProxyTest, KeepsItsGapAndIsNearestToTheDevice) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  int converged_steps = 0;
  int touching_steps = 0;
  int nearer_motions = 0;
  for (int walk = 0; walk < 12; ++walk) {
    Placement device{0.9 * draw().normalized(), turn_by(draw())};
    proxy.reset(device);
    const Vec3 towards = -device.position.normalized();
    const Vec3 turn = 0.004 * draw();
    for (int n = 0; n < 200; ++n) {
      device.position += (n < 100 ? 0.005 : 0.0005) * towards + 0.001 * draw();
      device.orientation = (turn_by(turn) * device.orientation).normalized();
      const ToolProxyStep step = proxy.step(device);
      ASSERT_FALSE(step.is_blocked);
      ASSERT_FALSE(check.penetrates(proxy.placement())) << "walk " << walk << " step " << n;
      const double gap = least_gap(proxy.placement());
      ASSERT_GE(gap, 0.49 * ToolProxy::kContactOffset) << "walk " << walk << " step " << n;
      if (proxy.contacts().empty()) continue;
      ++touching_steps;
      if (!step.converged) continue;
      ++converged_steps;
      if (n % 20 != 0) continue;
      const double current_energy = energy(proxy.placement(), device);
      for (int trial = 0; trial < 200; ++trial) {
        // Less than two offsets long: after a longer one a penetration could look like a gap.
        RigidMotion motion{proxy.placement(), draw(), draw() / kTurnLength};
        motion = motion.scaled(1.9 * ToolProxy::kContactOffset * std::abs(uniform(random)) / motion.length(proxy.radius()));
        const Placement moved = motion.at(1.0);
        // The margin is twice the slope of the energy, times the tolerance of the rounds.
        if (energy(moved, device) < current_energy - 4.0 * std::sqrt(current_energy) * ToolProxy::kConverged * ToolProxy::kContactOffset) {
          nearer_motions += least_gap(moved) > 1.01 * ToolProxy::kContactOffset ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(touching_steps, 500);
  EXPECT_GT(converged_steps, touching_steps * 9 / 10);
  EXPECT_EQ(nearer_motions, 0);
}

// An earlier version repeated cycles of two to five placements until it reached kMaxRounds.
TEST_F(ToolProxyTest, RoundsThatGetNoNearerEndTheStep) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TriangleMesh knob = make_bumpy_sphere(0.1, 0.2, 300, 7);
  const ObjectGeometry knob_tool(knob, {Vec3::Zero(), scene.unit_m()});
  ToolProxy proxy_of_knob(knob_tool, scene, kTurnLength);
  int touching_steps = 0;
  int most_rounds = 0;
  for (int walk = 0; walk < 12; ++walk) {
    Placement device{0.9 * draw_in_cube(random).normalized(), turn_by(draw_in_cube(random))};
    proxy_of_knob.reset(device);
    const Vec3 towards = -device.position.normalized();
    const Vec3 turn = 0.004 * draw_in_cube(random);
    for (int n = 0; n < 200; ++n) {
      device.position += (n < 100 ? 0.005 : 0.0005) * towards + 0.001 * draw_in_cube(random);
      device.orientation = (turn_by(turn) * device.orientation).normalized();
      most_rounds = std::max(most_rounds, proxy_of_knob.step(device).rounds);
      touching_steps += proxy_of_knob.contacts().empty() ? 0 : 1;
    }
  }
  EXPECT_GT(touching_steps, 500);
  EXPECT_LT(most_rounds, ToolProxy::kMaxRounds);
}

// A tool that was nearly at rest is moved far along the surface. An earlier version searched once along the whole motion, which crossed the
// surface at its beginning, and found up to 4,093 pairs.
TEST(ToolProxy, ALongMotionIsSearchedFromItsBeginning) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const TriangleMesh ball = make_bumpy_sphere(0.3, 0.02, 20000, 5);
  const TriangleMesh knob = make_bumpy_sphere(0.1, 0.02, 2000, 7);
  const TouchGeometry scene{std::vector<const TriangleMesh*>{&ball}};
  const ObjectGeometry tool(knob, {Vec3::Zero(), scene.unit_m()});
  ToolProxy proxy(tool, scene, 0.2);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto draw = [&] {
    const double z = uniform(random);
    const double y = uniform(random);
    return Vec3(uniform(random), y, z);
  };
  int touching_steps = 0;
  std::size_t most_features = 0;
  for (int walk = 0; walk < 40; ++walk) {
    constexpr std::array<double, 4> kHopLengths = {0.002, 0.005, 0.01, 0.02};
    Vec3 at = draw().normalized();
    Placement device{0.45 * at, turn_by(draw())};
    proxy.reset(device);
    for (int n = 0; n < 60; ++n) {
      device.position = (0.3 + 0.1 + 0.05 - std::min(0.08, 0.02 * n)) * at;
      const ToolProxyStep step = proxy.step(device);
      if (n > 10 && !proxy.contacts().empty()) {
        ++touching_steps;
        most_features = std::max(most_features, step.feature_count);
      }
      if (n > 8 && n % 4 == 0) at = (at + kHopLengths[walk / 10] * draw()).normalized();
    }
  }
  EXPECT_GT(touching_steps, 1000);
  EXPECT_LT(most_features, 1000U);
}

TEST(ToolProxy, APlateThatLeavesAContactFastStaysOut) {
  constexpr unsigned kSeed = 4245;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  const auto draw = [&] { return draw_in_cube(random); };
  const TriangleMesh bumps = make_bumpy_sphere(0.4, 0.3, 1000, 5);
  const TouchGeometry scene(std::vector<const TriangleMesh*>{&bumps});
  const ObjectGeometry tool(make_thin_wall(0.25, 1e-3, 3), {Vec3::Zero(), scene.unit_m()});
  ToolProxy proxy(tool, scene, 0.1);
  PenetrationCheck check(tool, scene);
  int touching_steps = 0;
  for (int walk = 0; walk < 20; ++walk) {
    Placement device{0.9 * draw().normalized(), turn_by(3.0 * draw())};
    proxy.reset(device);
    for (int n = 0; n < 100; ++n) {
      device.position += 0.02 * (draw() - 0.3 * device.position.normalized());
      device.orientation = (turn_by(0.1 * draw()) * device.orientation).normalized();
      proxy.step(device);
      touching_steps += proxy.contacts().empty() ? 0 : 1;
      ASSERT_FALSE(check.penetrates(proxy.placement())) << "walk " << walk << " step " << n;
    }
  }
  EXPECT_GT(touching_steps, 200);
}

TEST_F(ToolProxyTest, ATurnOfHalfARoundInFreeSpaceIsFollowed) {
  Placement device{Vec3(3.0, 0.0, 0.0), Quat::Identity()};
  proxy.reset(device);
  device.orientation = turn_by({0.0, 3.0, 0.0});
  device.position.y() = 2.0;
  EXPECT_TRUE(proxy.step(device).converged);
  EXPECT_EQ(proxy.placement().position, device.position);
  EXPECT_TRUE(proxy.contacts().empty());
}

TEST_F(ToolProxyTest, AnOverlapAtTheStartBlocksUntilTheDeviceHasLeft) {
  Placement device{Vec3(0.6, 0.0, 0.0), Quat::Identity()};
  for (; !proxy.step(device).is_blocked; device.position.x() -= 0.01) {
    proxy.reset(device);
    ASSERT_GT(device.position.x(), 0.0);
  }
  EXPECT_TRUE(proxy.step(device).is_blocked);
  device.position.x() = 1.5;
  EXPECT_FALSE(proxy.step(device).is_blocked);
  EXPECT_TRUE(proxy.contacts().empty());
}

}  // namespace
}  // namespace hapton
