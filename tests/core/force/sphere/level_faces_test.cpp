// A sphere over faces that lie in one plane: discs whose triangles meet in their middle, as at each end of a CAD cylinder.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "core/force/proxy/proxy_method.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kBallRadius = 0.0005;
constexpr double kDiscRadius = 0.05;
constexpr double kFanStiffness = 1000.0;

TriangleMesh cylinder_of(std::uint32_t segments) {
  TriangleMesh mesh;
  mesh.vertices = {{0.0, 0.0, 0.0}, {0.0, 0.0, -0.04}};
  for (std::uint32_t i = 0; i < segments; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / segments;
    const Vec3 out(kDiscRadius * std::cos(angle), kDiscRadius * std::sin(angle), 0.0);
    mesh.vertices.push_back(out);
    mesh.vertices.push_back(out - Vec3(0.0, 0.0, 0.04));
  }
  for (std::uint32_t i = 0; i < segments; ++i) {
    const std::uint32_t a = 2 + 2 * i;
    const std::uint32_t b = 2 + 2 * ((i + 1) % segments);
    mesh.triangles.insert(mesh.triangles.end(), {{0, a, b}, {1, b + 1, a + 1}, {a, a + 1, b + 1}, {a, b + 1, b}});
  }
  return mesh;
}

class OverAFlatFan : public testing::TestWithParam<std::uint32_t> {
 protected:
  OverAFlatFan() { RecordProperty("seed", std::to_string(kSeed)); }

  // Lines over the disc, each within a millimetre of its middle, 0.12 mm a step. visit(force, device) is called in each step.
  template <class Visit>
  void slide(const Material& material, Visit&& visit) {
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();
    TriangleMesh mesh = cylinder_of(GetParam());
    for (Vec3& v : mesh.vertices) v = turn * v;
    const auto method =
        make_method({.name = "proxy", .probe_radius_m = kBallRadius}, {.objects = {{made::shared(mesh), material}}}).value();
    for (int line = 0; line < 6; ++line) {
      const double angle = std::numbers::pi * unit(random_);
      const Vec3 along(std::cos(angle), std::sin(angle), 0.0);
      const Vec3 middle(1e-3 * unit(random_), 1e-3 * unit(random_), kBallRadius - 0.0015);
      method->reset(turn * (middle - 0.01 * along + Vec3(0.0, 0.0, 0.002)));
      for (int i = 0; i < 160; ++i) {
        const Vec3 device = middle + (1.2e-4 * i - 0.01) * along;
        const MethodOutput out = method->step({.p_SD = turn * device, .dt_s = 1e-3});
        carried_ += method->carried_from().has_value() ? 1 : 0;
        visit(Vec3(turn.transpose() * out.force_n), device);
      }
    }
  }

  static constexpr unsigned kSeed = 202611271;
  std::mt19937_64 random_{kSeed};
  int carried_ = 0;
};

// The force is that of the plane. No motion is left for the next step: such a rest once dragged the sphere with several newtons.
TEST_P(OverAFlatFan, TheForceIsThatOfThePlane) {
  slide({.stiffness_n_per_m = kFanStiffness}, [&](const Vec3& force_n, const Vec3& device) {
    ASSERT_NEAR(force_n.z(), kFanStiffness * (kBallRadius - device.z()), 1e-6);
    ASSERT_LE(force_n.head<2>().norm(), 1e-6);
  });
  EXPECT_EQ(carried_, 0);
}

TEST_P(OverAFlatFan, FrictionIsThatOfThePlane) {
  constexpr double kMu = 0.3;
  double most_friction_n = 0.0;
  slide({.stiffness_n_per_m = kFanStiffness, .friction_static = kMu, .friction_dynamic = kMu},
        [&](const Vec3& force_n, const Vec3& device) {
          ASSERT_NEAR(force_n.z(), kFanStiffness * (kBallRadius - device.z()), 1e-6);
          ASSERT_LE(force_n.head<2>().norm(), kMu * force_n.z() + 1e-6);
          most_friction_n = std::max(most_friction_n, force_n.head<2>().norm());
        });
  EXPECT_NEAR(most_friction_n, kMu * 1.5, 1e-6);  // pressed with 1.5 N: 1.5 mm deep
  EXPECT_EQ(carried_, 0);
}

INSTANTIATE_TEST_SUITE_P(Segments, OverAFlatFan, testing::Values(128U, 360U, 720U, 900U));

// To gather so many triangles uses up the work of a step: part of the motion is carried in the step in which the ball comes down.
class OverAVeryFlatFan : public OverAFlatFan {};

TEST_P(OverAVeryFlatFan, TheForceIsThatOfThePlaneAfterTheFirstStep) {
  int wrong_steps = 0;
  slide({.stiffness_n_per_m = kFanStiffness}, [&](const Vec3& force_n, const Vec3& device) {
    const Vec3 force(0.0, 0.0, kFanStiffness * (kBallRadius - device.z()));
    wrong_steps += (force_n - force).norm() > 1e-6 ? 1 : 0;
  });
  EXPECT_LE(wrong_steps, 6) << "one of each line";
  EXPECT_LE(carried_, 6);
}

INSTANTIATE_TEST_SUITE_P(Segments, OverAVeryFlatFan, testing::Values(2000U, 5000U));

// The ball leaves the disc over its rim as over any other edge, and is then held by the wall.
TEST(OverLevelFaces, TheRimOfAFanIsAnEdge) {
  const auto method = make_method({.name = "proxy", .probe_radius_m = kBallRadius},
                                  {.objects = {{made::shared(cylinder_of(360)), {.stiffness_n_per_m = kFanStiffness}}}})
                          .value();
  method->reset(Vec3(0.0, 1e-4, 0.002));
  const double wall = kDiscRadius * std::cos(std::numbers::pi / 360.0);
  MethodOutput out;
  for (int i = 0; i < 500; ++i) out = method->step({.p_SD = Vec3(1.2e-4 * i, 1e-4, kBallRadius - 0.0005), .dt_s = 1e-3});
  EXPECT_FALSE(out.contact) << "beside the wall";
  for (int i = 0; i < 40; ++i) out = method->step({.p_SD = Vec3(0.06 - 1e-4 * i, 1e-4, -0.01 - 1e-4 * i), .dt_s = 1e-3});
  for (int i = 0; i < 70; ++i) out = method->step({.p_SD = Vec3(0.056 - 1e-4 * i, 1e-4, -0.014), .dt_s = 1e-3});
  EXPECT_NEAR(out.force_n.x(), kFanStiffness * (wall + kBallRadius - 0.0491), 1e-3);
  EXPECT_NEAR(out.force_n.z(), 0.0, 1e-6);
}

}  // namespace
}  // namespace hapton
