// A sphere where thousands of triangles meet in one vertex: at the tip of a cone, on both sides.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>

#include "core/force/proxy/proxy_method.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kConeBallRadius = 0.0005;
constexpr double kConeRimRadius = 0.05;
constexpr double kConeStiffness = 1000.0;
constexpr double kConeDepth = 0.001;  // depth of the device below the position of a ball in contact

// A cone from a tip at the given height, above or below zero, to a rim at zero; closed by a second cone below.
TriangleMesh cone_of(std::uint32_t segments, double height) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, height}, {0.0, 0.0, -0.04}};
  for (std::uint32_t i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    mesh.vertices.emplace_back(kConeRimRadius * std::cos(angle), kConeRimRadius * std::sin(angle), 0.0);
  }
  for (std::uint32_t i = 0; i < segments; ++i) {
    const std::uint32_t a = 2 + i;
    const std::uint32_t b = 2 + (i + 1) % segments;
    mesh.triangles.insert(mesh.triangles.end(), {{0, a, b}, {1, b, a}});
  }
  return mesh;
}

// The force on a ball at a smooth cone whose tip points up, for a device inside. None: the tip holds the ball.
std::optional<Vec3> force_of_cone(double height, const Vec3& device) {
  const double slope = std::hypot(kConeRimRadius, height);
  const Vec3 out = Vec3(device.x(), device.y(), 0.0).normalized();
  const Vec3 normal = (height * out + kConeRimRadius * Vec3::UnitZ()) / slope;
  const Vec3 down = (kConeRimRadius * out - height * Vec3::UnitZ()) / slope;
  const Vec3 off = device - Vec3(0.0, 0.0, height);
  if (off.dot(down) <= 0.0) return std::nullopt;
  return Vec3(kConeStiffness * std::max(0.0, kConeBallRadius - normal.dot(off)) * normal);
}

class OverACone : public testing::TestWithParam<std::uint32_t> {
 protected:
  OverACone() { RecordProperty("seed", std::to_string(kSeed)); }

  std::unique_ptr<ForceMethod> method_over(double height) const {
    return make_method({.name = "proxy", .probe_radius_m = kConeBallRadius},
                       {.objects = {{made::shared(cone_of(GetParam(), height)), {.stiffness_n_per_m = kConeStiffness}}}})
        .value();
  }

  // Lines past the tip, 0.12 mm a step. visit(device) is called in each step.
  template <class Visit>
  void slide(double height, ForceMethod& method, Visit&& visit) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (int line = 0; line < 6; ++line) {
      const double angle = std::numbers::pi * unit(random_);
      const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
      const Vec3 beside = 3e-4 * unit(random_) * Vec3(-along.y(), along.x(), 0.0);
      const auto place = [&](int i) {
        const Vec3 p = (1.2e-4 * i - 0.005) * along + beside;
        return Vec3(p.x(), p.y(),
                    height * (1.0 - p.norm() / kConeRimRadius) + kConeBallRadius * std::hypot(kConeRimRadius, height) / kConeRimRadius -
                        kConeDepth);
      };
      method.reset(place(0) + Vec3(0.0, 0.0, 0.003));
      for (int i = 0; i < 84; ++i) visit(place(i));
    }
  }

  static constexpr unsigned kSeed = 202611272;
  std::mt19937_64 random_{kSeed};
};

// The faces turn the force by at most half of their angle. Some steps run out of work: where the ball comes down, and where it gets round
// the tip of 1,000 faces or more at once. Before fans were crossed without events, nearly all steps near the tip did.
TEST_P(OverACone, TheForceIsThatOfTheCone) {
  constexpr double kHeight = 0.02;
  const auto method = method_over(kHeight);
  int carried_steps = 0;
  int wrong_steps = 0;
  int steps = 0;
  slide(kHeight, *method, [&](const Vec3& device) {
    const MethodOutput out = method->step({.p_SD = device, .dt_s = 1e-3});
    carried_steps += method->carried_from().has_value() ? 1 : 0;
    const auto force = force_of_cone(kHeight, device);
    if (!force) return;
    ++steps;
    const double rounding = (2.0 * std::numbers::pi / GetParam() + 1e-4) * force->norm() + 1e-3;
    wrong_steps += (out.force_n - *force).norm() > rounding ? 1 : 0;
  });
  const int limit = GetParam() < 1000 ? 10 : GetParam() < 3000 ? 30 : 60;
  EXPECT_GT(steps, 450);
  EXPECT_LE(wrong_steps, limit) << "of " << steps << " steps";
  EXPECT_LE(carried_steps, limit);
}

// Where the tip points down, the ball lags behind in some steps. As soon as the device rests, the ball arrives, and stays.
TEST_P(OverACone, TheBallArrivesWhereTheDeviceRests) {
  constexpr int kMaxSteps = 100;
  for (const double height : {0.02, -0.02, -0.002}) {
    const auto method = method_over(height);
    int n = 0;
    int most_repeats = 0;
    slide(height, *method, [&](const Vec3& device) {
      method->step({.p_SD = device, .dt_s = 1e-3});
      if (++n % 7 != 0) return;
      int repeats = 0;
      for (; method->carried_from() && repeats < kMaxSteps; ++repeats) method->step({.p_SD = device, .dt_s = 1e-3});
      most_repeats = std::max(most_repeats, repeats);
      const Vec3 force = method->step({.p_SD = device, .dt_s = 1e-3}).force_n;
      const MethodOutput again = method->step({.p_SD = device, .dt_s = 1e-3});
      EXPECT_LE((again.force_n - force).norm(), 1e-6);
      EXPECT_LE((again.p_SP - device).norm(), kConeDepth + 1e-4) << "stuck";
    });
    EXPECT_LT(most_repeats, kMaxSteps) << "height " << height;
  }
}

// The live node builds an object when the probe comes near: the steps are then the same.
TEST_P(OverACone, BuiltOnApproachItIsTheSame) {
  for (const double height : {0.02, -0.02}) {
    const TouchScene scene = {.objects = {{made::shared(cone_of(GetParam(), height)), {.stiffness_n_per_m = kConeStiffness}}}};
    MethodSettings on_approach = {.name = "proxy", .probe_radius_m = kConeBallRadius};
    const auto at_once = make_method(on_approach, scene).value();
    on_approach.build_on_approach = true;
    const auto built_on_approach = make_method(on_approach, scene).value();
    const auto place = [&](int n) {
      const Vec3 p(1.2e-4 * n - 0.005, 1e-4, 0.0);
      return Vec3(
          p.x(), p.y(),
          height * (1.0 - p.norm() / kConeRimRadius) + kConeBallRadius * std::hypot(kConeRimRadius, height) / kConeRimRadius - kConeDepth);
    };
    for (const auto& method : {at_once.get(), built_on_approach.get()}) {
      method->reset(place(0) + Vec3(0.0, 0.0, 0.003));
      method->step({.p_SD = place(0) + Vec3(0.0, 0.0, 0.003), .dt_s = 1e-3});
    }
    built_on_approach->prepare();
    int contacts = 0;
    for (int n = 0; n < 84; ++n) {
      const MethodInput input = {.p_SD = place(n), .dt_s = 1e-3};
      const MethodOutput expected = at_once->step(input);
      const MethodOutput out = built_on_approach->step(input);
      ASSERT_EQ(out.force_n, expected.force_n) << "height " << height << ", step " << n;
      contacts += out.contact ? 1 : 0;
    }
    EXPECT_GT(contacts, 70);
  }
}

INSTANTIATE_TEST_SUITE_P(Segments, OverACone, testing::Values(360U, 1000U, 3000U));

// A pin beside the tip, or a wall across the hollow: cone and other body both hold the ball, and it never passes the other body.
TEST(BesideAFan, TheForceIsThatOfTheReference) {
  for (const double height : {0.02, -0.02}) {
    SCOPED_TRACE(height);
    const double tip = height;
    TriangleMesh other = height > 0.0 ? make_box({3e-4, 3e-4, 4e-3}) : make_box({2e-4, 0.02, 0.012});
    const Vec3 at = height > 0.0 ? Vec3(1.1e-3, 2e-4, tip) : Vec3(1.5e-3, 0.0, tip + 0.004);
    const TriangleMesh mesh = joined(cone_of(100, height), scaled_and_moved(other, 1.0, at));
    const TouchScene scene = {.objects = {{made::shared(mesh), {.stiffness_n_per_m = kConeStiffness}}}};
    const auto method = make_method({.name = "proxy", .probe_radius_m = kConeBallRadius}, scene).value();
    const auto reference = make_method({.name = "reference", .probe_radius_m = kConeBallRadius}, scene).value();
    double worst = 0.0;
    int contacts = 0;
    for (int n = 0; n <= 600; ++n) {
      // Across the tip towards the other body, into it, along it and back.
      const double turn = 2.0 * std::numbers::pi * n / 600;
      const Vec3 device(2.2e-3 * std::sin(turn) - 4e-4, 9e-4 * std::sin(2.0 * turn),
                        height > 0.0 ? tip + 2e-4 - 3e-4 * std::abs(std::sin(turn)) : tip + 1.2e-3 - 4e-4 * std::sin(3.0 * turn));
      const MethodInput input = {.p_SD = n == 0 ? Vec3(0.0, 0.0, tip + 4e-3) : device, .dt_s = 1e-3};
      if (n == 0) {
        method->reset(input.p_SD);
        reference->reset(input.p_SD);
      }
      Vec3 force = method->step(input).force_n;
      for (int repeats = 0; repeats < 50 && method->carried_from(); ++repeats) force = method->step(input).force_n;
      const MethodOutput expected = reference->step(input);
      worst = std::max(worst, (force - expected.force_n).norm());
      contacts += expected.contact ? 1 : 0;
    }
    EXPECT_GT(contacts, 150);
    EXPECT_LT(worst, 1e-3);
  }
}

}  // namespace
}  // namespace hapton
