#include "core/force/smooth/smooth_force.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/force/smooth/smooth_scene.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kLayerStiffness = 1000.0;

std::vector<SetTriangle> set_of(const TriangleMesh& mesh, bool two_sided = true) {
  TouchScene scene;
  scene.objects.push_back({made::shared(mesh), {.stiffness_n_per_m = kLayerStiffness, .two_sided = two_sided}});
  const auto built = SmoothScene::build(scene, {});
  std::vector<SetTriangle> all;
  built->for_each([&all](const SetTriangle& t) { all.push_back(t); });
  return all;
}

SmoothForce force_at(const std::vector<SetTriangle>& triangles, const Vec3& P, double radius, double layer) {
  SmoothForceSum sum(P, radius);
  for (const SetTriangle& t : triangles) sum.add(t);
  return sum.combine(layer, std::array{Material{.stiffness_n_per_m = kLayerStiffness}});
}

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

// Over a plane the force is known, over faces, edges and vertices alike: straight up, k (layer - height).
TEST(SmoothForce, OverAPlaneIsExact) {
  const auto triangles = set_of(make_plane_grid(0.1, 10));
  const std::uint64_t seed = 81;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-0.04, 0.04);
  for (int i = 0; i < 2000; ++i) {
    Vec3 P(unit(random), unit(random), 1e-5 + 0.004 * (i % 7) / 7.0);
    if (i % 3 == 0) P.x() = 0.01 * std::round(P.x() * 100.0);  // over an edge
    if (i % 6 == 0) P.y() = 0.01 * std::round(P.y() * 100.0);  // over a vertex
    const SmoothForce felt = force_at(triangles, P, 0.005, 0.005);
    EXPECT_GE(felt.vcps, 1U);
    EXPECT_LT((felt.force_n - Vec3(0, 0, kLayerStiffness * (0.005 - P.z()))).norm(), 1e-9) << P.transpose();
    EXPECT_LT((felt.D - Vec3(P.x(), P.y(), 0)).norm(), 1e-12);
  }
}

// The probe goes round a sphere at one height: the direction of the force differs from outwards by a fraction of the facets' own error, and
// turns evenly, as the probe moves.
TEST(SmoothForce, OverASphereIsRadialAndDoesNotBounce) {
  constexpr double kRadius = 0.05;
  const auto triangles = set_of(make_icosphere(kRadius, 3));
  double facet_error = 0.0;
  for (const SetTriangle& t : triangles) facet_error = std::max(facet_error, angle_between(t.face_normal, t.corner[0]));
  Vec3 last = Vec3::Zero();
  Vec3 last_P = Vec3::Zero();
  double worst_angle = 0.0;
  double worst_turn = 0.0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double a = 6.283185307179586 * i / kSteps;
    const Vec3 P = (kRadius + 0.002) * Vec3(std::cos(a), 0.8 * std::sin(a), 0.6 * std::sin(a));
    const SmoothForce felt = force_at(triangles, P, 0.004, 0.004);
    ASSERT_FALSE(felt.force_n.isZero(0.0)) << "a gap at step " << i;
    worst_angle = std::max(worst_angle, angle_between(felt.force_n, P));
    if (i > 0) worst_turn = std::max(worst_turn, angle_between(felt.force_n, last) / angle_between(P, last_P));
    last = felt.force_n;
    last_P = P;
  }
  EXPECT_LT(worst_angle, 0.3 * facet_error);
  EXPECT_LT(worst_turn, 3.0) << "the force turns at most three times as fast as the probe goes round";
}

// Round the edges and corners of a box the force is never zero, and continuous. Without the corner fans there is no force at a corner.
TEST(SmoothForce, RoundABoxIsContinuousAndCoversCorners) {
  const auto triangles = set_of(make_box(Vec3(0.1, 0.1, 0.1), 4));
  std::vector<SetTriangle> without_corners;
  for (const SetTriangle& t : triangles) {
    if (t.kind != SurfaceKind::corner_fan) without_corners.push_back(t);
  }
  const Vec3 corner(0.05, 0.05, 0.05);
  EXPECT_TRUE(force_at(without_corners, corner + Vec3(1e-3, 1e-3, 1e-3), 0.005, 0.005).force_n.isZero(0.0));

  Vec3 last = Vec3::Zero();
  double worst_jump_n = 0.0;
  constexpr int kSteps = 10000;
  for (int i = 0; i < kSteps; ++i) {
    // Near the corner, over three faces, three edges and the corner itself, always outside.
    const double a = 6.283185307179586 * i / kSteps;
    const Vec3 offset(0.003 * std::cos(a), 0.003 * std::cos(a + 2.0944), 0.003 * std::cos(a + 4.18879));
    const Vec3 P = corner + offset + Vec3(0.0022, 0.0022, 0.0022);
    const SmoothForce felt = force_at(triangles, P, 0.006, 0.006);
    ASSERT_FALSE(felt.force_n.isZero(0.0)) << "a gap at " << (P - corner).transpose();
    const Vec3 outside = (P - corner).cwiseMax(Vec3::Zero());  // from the nearest point of the box to P
    EXPECT_LT(angle_between(felt.force_n, outside), 0.35);
    if (i > 0) worst_jump_n = std::max(worst_jump_n, (felt.force_n - last).norm());
    last = felt.force_n;
  }
  const double step = 0.003 * std::sqrt(1.5) * 6.283185307179586 / kSteps;
  EXPECT_LT(worst_jump_n, 12.0 * kLayerStiffness * step);
}

// At a blunt concave edge both faces overlap; the degenerate triangles subtract what is counted twice, so no face's share ends with a
// discontinuity.
TEST(SmoothForce, OverAConcaveEdgeIsContinuous) {
  // A valley whose sides rise by 25 degrees: the concave edge has 50 degrees.
  const double slope = std::tan(25.0 * 3.14159265358979 / 180.0);
  TriangleMesh mesh;
  for (int j = 0; j <= 8; ++j) {
    for (int i = 0; i <= 8; ++i) mesh.vertices.emplace_back(0.01 * (i - 4), 0.01 * (j - 4), slope * std::fabs(0.01 * (i - 4)));
  }
  for (std::uint32_t j = 0; j < 8; ++j) {
    for (std::uint32_t i = 0; i < 8; ++i) {
      const std::uint32_t a = j * 9 + i;
      mesh.triangles.push_back({a, a + 1, a + 10});
      mesh.triangles.push_back({a, a + 10, a + 9});
    }
  }
  const auto triangles = set_of(mesh, false);
  ASSERT_TRUE(std::any_of(triangles.begin(), triangles.end(), [](const SetTriangle& t) { return t.kind == SurfaceKind::edge_fan; }));
  std::vector<SetTriangle> faces_only;
  for (const SetTriangle& t : triangles) {
    if (t.kind == SurfaceKind::face) faces_only.push_back(t);
  }
  const auto worst_jump = [](const std::vector<SetTriangle>& some) {
    double worst = 0.0;
    Vec3 last = Vec3::Zero();
    for (int i = 0; i <= 5000; ++i) {
      const SmoothForce felt = force_at(some, Vec3(-0.006 + 0.012 * i / 5000.0, 0.0013, 0.004), 0.006, 0.006);
      if (i > 0) worst = std::max(worst, (felt.force_n - last).norm());
      last = felt.force_n;
    }
    return worst;
  };
  const double step = kLayerStiffness * 0.012 / 5000.0;
  EXPECT_LT(worst_jump(triangles), 10.0 * step);
  EXPECT_GT(worst_jump(faces_only), 75.0 * step) << "without the fans there is no jump: this test proves nothing";
}

// Fig. 3: of two sheets one above the other only the upper one exerts a force.
TEST(SmoothForce, RemovesHiddenVcps) {
  TriangleMesh sheets = joined(make_plane_grid(0.02, 2), scaled_and_moved(make_plane_grid(0.02, 2), 1.0, Vec3(0, 0, -0.001)));
  const auto triangles = set_of(sheets);
  const SmoothForce felt = force_at(triangles, Vec3(0.0011, 0.0007, 0.001), 0.004, 0.004);
  EXPECT_EQ(felt.vcps, 2U);
  EXPECT_EQ(felt.hidden, 1U);
  EXPECT_NEAR(felt.D.z(), 0.0, 1e-12);
  EXPECT_NEAR(felt.force_n.z(), kLayerStiffness * 0.003, 1e-9);
}

TEST(SmoothForce, OneSidedIsTouchedFromItsFrontOnly) {
  const Vec3 above(0.001, 0.002, 0.001);
  const Vec3 below(0.001, 0.002, -0.001);
  const auto one_sided = set_of(make_plane_grid(0.1, 4), false);
  const auto two_sided = set_of(make_plane_grid(0.1, 4), true);
  EXPECT_GT(force_at(one_sided, above, 0.004, 0.004).force_n.z(), 0.0);
  EXPECT_TRUE(force_at(one_sided, below, 0.004, 0.004).force_n.isZero(0.0));
  EXPECT_LT(force_at(two_sided, below, 0.004, 0.004).force_n.z(), 0.0);
}

// The last line of Algorithm 1: several VCPs give the direction, and the strongest of them gives the magnitude.
TEST(SmoothForce, TheStrongestVcpGivesTheMagnitude) {
  TriangleMesh corner;  // floor and wall, unconnected: no fans between them
  corner = joined(make_plane_grid(0.1, 4), corner);
  TriangleMesh wall = make_plane_grid(0.1, 4);
  for (Vec3& v : wall.vertices) v = Vec3(-0.02, v.x(), v.y() + 0.051);
  corner = joined(corner, wall);
  const auto triangles = set_of(corner);
  const Vec3 P(-0.017, 0.0013, 0.002);
  const SmoothForce felt = force_at(triangles, P, 0.01, 0.005);
  EXPECT_NEAR(felt.force_n.norm(), kLayerStiffness * 0.003, 1e-9);
  EXPECT_NEAR(felt.force_n.x() / felt.force_n.z(), 2.0 / 3.0, 1e-9);
}

TEST(SmoothForce, DoesNotDependOnTheOrder) {
  auto triangles = set_of(make_staircase(0.05, 4, 3));
  const std::uint64_t seed = 82;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-0.03, 0.03);
  for (int i = 0; i < 200; ++i) {
    const Vec3 P(unit(random), unit(random), unit(random));
    const SmoothForce one = force_at(triangles, P, 0.006, 0.006);
    std::shuffle(triangles.begin(), triangles.end(), random);
    const SmoothForce other = force_at(triangles, P, 0.006, 0.006);
    EXPECT_EQ(one.force_n, other.force_n);
    EXPECT_EQ(one.D, other.D);
  }
}

TEST(SmoothForce, TheLawIsASpringThatBeginsAtTheLayer) {
  EXPECT_EQ(smooth_f(1000.0, 0.002, 0.002), 0.0);
  EXPECT_EQ(smooth_f(1000.0, 0.002, 0.003), 0.0);
  EXPECT_DOUBLE_EQ(smooth_f(1000.0, 0.002, 0.0005), 1.5);
  EXPECT_EQ(smooth_f(1000.0, 0.0, 0.0), 0.0);
}

TEST(SmoothNormal, OnEdgesAndAtVerticesItIsTheInterpolatedNormal) {
  const auto triangles = set_of(make_icosphere(0.05, 2));
  for (const SetTriangle& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      const int j = (k + 1) % 3;
      EXPECT_LT((smooth_normal_at(t, t.corner[k]) - t.normal[k]).norm(), 1e-7);
      const Vec3 middle = 0.25 * t.corner[k] + 0.75 * t.corner[j];
      EXPECT_LT((smooth_normal_at(t, middle) - (0.25 * t.normal[k] + 0.75 * t.normal[j]).normalized()).norm(), 1e-7);
    }
  }
}

// A line through any point of a closed surface, also exactly through a vertex or an edge, meets a triangle there.
TEST(StraightLine, IsWatertight) {
  const std::uint64_t seed = 83;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const TriangleMesh mesh = made::sphere(0.05, 12, 0.1);
  for (int i = 0; i < 20000; ++i) {
    const auto t = random() % mesh.triangles.size();
    Vec3 through = mesh.corner(t, i % 3);
    if (i % 2 == 0) through = through + (mesh.corner(t, (i + 1) % 3) - through) * (0.5 + 0.5 * unit(random));
    const Vec3 from = i % 5 == 0 ? Vec3(0.0, 0.0, 0.0) : Vec3(0.02 * Vec3(unit(random), unit(random), unit(random)));
    const Vec3 to = from + (through - from) * (i % 7 == 0 ? 1.0 : 2.0);
    const StraightLine line(from, to);
    bool is_met = false;
    for (std::size_t u = 0; u < mesh.triangles.size() && !is_met; ++u) {
      double at = 0.0;
      is_met = line.meets({mesh.corner(u, 0), mesh.corner(u, 1), mesh.corner(u, 2)}, at) && at > 0.0;
    }
    EXPECT_TRUE(is_met) << i;
  }
}

TEST(StraightLine, SaysWhereOnTheLineItMeetsATriangle) {
  const std::array<Vec3, 3> corner = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  double at = -1.0;
  ASSERT_TRUE(StraightLine(Vec3(0.2, 0.3, 3.0), Vec3(0.2, 0.3, -1.0)).meets(corner, at));
  EXPECT_NEAR(at, 0.75, 1e-15);
  ASSERT_TRUE(StraightLine(Vec3(0.2, 0.3, 1.0), Vec3(0.2, 0.3, 2.0)).meets(corner, at));
  EXPECT_NEAR(at, -1.0, 1e-15);
  EXPECT_FALSE(StraightLine(Vec3(0.7, 0.7, 1.0), Vec3(0.7, 0.7, -1.0)).meets(corner, at));
  EXPECT_FALSE(StraightLine(Vec3(0.2, 0.3, 0.0), Vec3(0.9, 0.3, 0.0)).meets(corner, at)) << "within the plane";
  EXPECT_FALSE(StraightLine(Vec3(1, 1, 1), Vec3(1, 1, 1)).meets(corner, at)) << "no line";
}

}  // namespace
}  // namespace hapton
