#include "core/geometry/normal_fans.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/smooth_surface.h"

namespace hapton {
namespace {

// A box has three normals at each corner: each edge gets two degenerate triangles, each corner one.
TEST(NormalFans, ABoxGetsFansAlongEdgesAndInCorners) {
  SmoothSurfaceReport report;
  const auto surface = make_smooth_surface(make_box(Vec3(1, 1, 1)), {.longest_edge = 0.0}, report);
  ASSERT_TRUE(surface);
  EXPECT_EQ(surface->face_count, 12U);
  EXPECT_EQ(report.fans.edge_fans, 24U);
  EXPECT_EQ(report.fans.corner_fans, 8U);
  EXPECT_EQ(report.fans.open_corners, 0U);
  for (std::size_t t = surface->face_count; t < surface->mesh.triangles.size(); ++t) {
    const Triangle& f = surface->mesh.triangles[t];
    const std::set<std::uint32_t> points(f.begin(), f.end());
    EXPECT_EQ(points.size(), surface->kind(t) == SurfaceKind::edge_fan ? 2U : 1U);
  }
}

// At either end of the crease between two triangles there are only two normals, so no corner can be filled; the report counts these ends.
TEST(NormalFans, ACreaseThatEndsOnABoundaryLeavesOpenCorners) {
  const TriangleMesh roof = {{Vec3(0, 0, 1), Vec3(1, 0, 1), Vec3(0, 1, 0), Vec3(0, -1, 0)}, {{0, 1, 2}, {1, 0, 3}}};
  SmoothSurfaceReport report;
  ASSERT_TRUE(make_smooth_surface(roof, {.longest_edge = 0.0}, report));
  EXPECT_EQ(report.fans.edge_fans, 2U);
  EXPECT_EQ(report.fans.corner_fans, 0U);
  EXPECT_EQ(report.fans.open_corners, 2U);
}

// The fans close the surface of normals: at every side of every triangle, degenerate or not, another triangle has the reversed side with
// the same normals, so no direction is left out and none is covered twice.
TEST(NormalFans, FansLeaveNoGapBetweenNormals) {
  for (const TriangleMesh& mesh : {make_box(Vec3(1, 2, 3), 2), make_cylinder(1.0, 2.0, 12),
                                   make_prism({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}, {0, 2}}, 1.0, 2), make_staircase(1.0, 3, 2)}) {
    SmoothSurfaceReport report;
    const auto surface = make_smooth_surface(mesh, {}, report);
    ASSERT_TRUE(surface);
    EXPECT_EQ(report.fans.open_corners, 0U);
    std::multiset<std::array<std::uint32_t, 4>> sides;
    const ShadedMesh& s = surface->mesh;
    const auto side = [&](std::size_t t, int k) {
      const int j = (k + 1) % 3;
      return std::array{s.triangles[t][k], s.corner_normals[t][k], s.triangles[t][j], s.corner_normals[t][j]};
    };
    for (std::size_t t = 0; t < s.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) sides.insert(side(t, k));
    }
    for (const auto& [v0, n0, v1, n1] : sides) {
      const std::array<std::uint32_t, 4> back = {v1, n1, v0, n0};
      EXPECT_EQ(sides.count(back), sides.count({v0, n0, v1, n1})) << v0 << " " << v1;
    }
  }
}

// A file may contain such a cone. A search among all changes of the normal at the tip would use up the time limit of the test.
TEST(NormalFans, AnyNumberOfNormalsMayMeetAtOneVertex) {
  constexpr std::uint32_t kCount = 1'000'000;
  ShadedMesh cone;
  cone.vertices.emplace_back(0.0, 0.0, 1.0);
  for (std::uint32_t t = 0; t < kCount; ++t) {
    const double angle = 2.0 * std::numbers::pi * t / kCount;
    cone.vertices.emplace_back(std::cos(angle), std::sin(angle), 0.0);
    cone.triangles.push_back({0, 1 + t, 1 + (t + 1) % kCount});
    cone.normals.push_back(Vec3(std::cos(angle), std::sin(angle), 1.0).normalized());
    cone.corner_normals.push_back({t, t, t});
    cone.source.push_back(t);
  }
  const NormalFanReport report = add_normal_fans(cone);
  EXPECT_EQ(report.edge_fans, 2 * kCount);
  EXPECT_EQ(report.corner_fans, kCount - 2) << "one ring around the tip";
  EXPECT_EQ(report.open_corners, kCount) << "around the base";
  const Triangle last_fan = cone.corner_normals.back();
  EXPECT_EQ(cone.corner_normals.size(), kCount + report.edge_fans + report.corner_fans);
  EXPECT_EQ(last_fan, (Triangle{kCount - 1, kCount - 3, kCount - 2}));
}

}  // namespace
}  // namespace hapton
