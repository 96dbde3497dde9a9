#include "core/collision/surface_adjacency.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kMargin = 1e-9;

std::array<Vec3, 3> corners(const TriangleMesh& mesh, std::size_t t) { return {mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2)}; }

SurfaceAdjacency adjacency_of(const TriangleMesh& mesh) {
  std::vector<Box> boxes;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Box box;
    for (int k = 0; k < 3; ++k) box.grow(mesh.corner(t, k));
    boxes.push_back(box);
  }
  SurfaceAdjacency adjacency(mesh.vertices.size(), mesh.triangles);
  adjacency.find_walkable(mesh.vertices, mesh.triangles, WideBvh(boxes), kMargin);
  return adjacency;
}

// Whoever crosses an edge and crosses it back is where they were, on the side they were.
void expect_mutual(const TriangleMesh& mesh, const SurfaceAdjacency& adjacency) {
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const SurfaceAdjacency::Across there = adjacency.across(t, k);
      if (!there.exists) continue;
      const SurfaceAdjacency::Across back = adjacency.across(there.triangle, there.edge);
      EXPECT_TRUE(back.exists);
      EXPECT_EQ(back.triangle, t);
      EXPECT_EQ(back.edge, k);
      EXPECT_EQ(back.flips, there.flips);
    }
  }
}

TEST(SurfaceAdjacency, AClosedSurfaceIsWalkableAndKeepsItsSide) {
  for (const TriangleMesh& mesh : {make_icosphere(0.5, 3), make_box(Vec3(0.6, 0.5, 0.4), 3), make_torus(0.35, 0.15, 40, 20),
                                   make_bumpy_sphere(0.5, 0.2, 5000, 3), make_gutter(1.0, 0.5, 0.01, 4), make_thin_wall(1.0, 0.01, 4)}) {
    const SurfaceAdjacency adjacency = adjacency_of(mesh);
    EXPECT_EQ(adjacency.walkable_count(), mesh.triangles.size());
    expect_mutual(mesh, adjacency);
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) {
        EXPECT_TRUE(adjacency.across(t, k).exists);
        EXPECT_FALSE(adjacency.across(t, k).flips);
        EXPECT_NE(adjacency.across(t, k).triangle, t);
      }
    }
  }
}

TEST(SurfaceAdjacency, ABoundaryEdgeLeadsToTheBackOfItsOwnTriangle) {
  const TriangleMesh sheet = make_plane_grid(1.0, 4);
  const SurfaceAdjacency adjacency = adjacency_of(sheet);
  EXPECT_EQ(adjacency.walkable_count(), sheet.triangles.size());
  expect_mutual(sheet, adjacency);
  int boundary = 0;
  for (std::uint32_t t = 0; t < sheet.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const SurfaceAdjacency::Across across = adjacency.across(t, k);
      if (across.triangle != t) continue;
      EXPECT_TRUE(across.flips);
      EXPECT_EQ(across.edge, k);
      ++boundary;
    }
  }
  EXPECT_EQ(boundary, 16);
}

TEST(SurfaceAdjacency, ATriangleOrientedTheOtherWayIsReachedOnItsBack) {
  TriangleMesh ball = make_icosphere(0.5, 2);
  std::swap(ball.triangles[7][1], ball.triangles[7][2]);
  const SurfaceAdjacency adjacency = adjacency_of(ball);
  EXPECT_EQ(adjacency.walkable_count(), ball.triangles.size());
  expect_mutual(ball, adjacency);
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(adjacency.across(7, k).flips);
}

TEST(SurfaceAdjacency, AnEdgeOfThreeTrianglesHasNoNeighbours) {
  TriangleMesh mesh = make_box(Vec3::Constant(0.5), 1);
  const Triangle first = mesh.triangles[0];
  mesh.vertices.emplace_back(1.0, 1.0, 1.0);
  mesh.triangles.push_back({first[0], first[1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  const SurfaceAdjacency adjacency = adjacency_of(mesh);
  EXPECT_FALSE(adjacency.across(0, 0).exists);
  EXPECT_FALSE(adjacency.is_walkable(0));
  EXPECT_LT(adjacency.walkable_count(), mesh.triangles.size());
}

TEST(SurfaceAdjacency, TwoCopiesOfATriangleAreNotWalkable) {
  TriangleMesh ball = make_icosphere(0.5, 2);
  ball.triangles.push_back(ball.triangles[5]);
  const SurfaceAdjacency adjacency = adjacency_of(ball);
  EXPECT_FALSE(adjacency.is_walkable(5));
  EXPECT_FALSE(adjacency.is_walkable(static_cast<std::uint32_t>(ball.triangles.size() - 1)));
}

TEST(SurfaceAdjacency, TwoConesThatShareTheirTipAreNotWalkableThere) {
  const TriangleMesh cone{.vertices = {{0, 0, 0}, {1, 0, 1}, {0, 1, 1}, {-1, -1, 1}},
                          .triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 3}, {1, 2, 3}}};
  TriangleMesh both = cone;
  for (int k = 1; k < 4; ++k) both.vertices.emplace_back(-cone.vertices[k]);
  for (const Triangle& t : cone.triangles) {
    const auto other = [](std::uint32_t v) { return v == 0 ? 0U : v + 3; };
    both.triangles.push_back({other(t[0]), other(t[2]), other(t[1])});
  }
  const SurfaceAdjacency adjacency = adjacency_of(both);
  for (std::uint32_t t = 0; t < both.triangles.size(); ++t) EXPECT_EQ(adjacency.is_walkable(t), t % 4 == 3) << t;
}

// Of triangles that share no vertex those are walkable that are apart, every pair asked.
TEST(SurfaceAdjacency, WhereSurfacesMeetNothingIsWalkable) {
  const TriangleMesh mesh = joined(make_icosphere(0.3, 3), scaled_and_moved(make_icosphere(0.3, 3), 1.0, Vec3(0.31, 0.07, 0.02)));
  const SurfaceAdjacency adjacency = adjacency_of(mesh);
  std::vector<bool> meets(mesh.triangles.size(), false);
  for (std::size_t s = 0; s < mesh.triangles.size(); ++s) {
    for (std::size_t t = 0; t < s; ++t) {
      const bool shares = std::any_of(mesh.triangles[s].begin(), mesh.triangles[s].end(), [&](std::uint32_t v) {
        return std::find(mesh.triangles[t].begin(), mesh.triangles[t].end(), v) != mesh.triangles[t].end();
      });
      if (shares || are_apart(corners(mesh, s), corners(mesh, t), kMargin)) continue;
      meets[s] = true;
      meets[t] = true;
    }
  }
  EXPECT_GT(std::count(meets.begin(), meets.end(), true), 50);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) EXPECT_EQ(adjacency.is_walkable(t), !meets[t]) << t;
}

TEST(SurfaceAdjacency, ACrackNarrowerThanTheMarginIsNotWalkableAWiderOneIs) {
  for (const double width : {0.1 * kMargin, 10.0 * kMargin}) {
    const TriangleMesh left = make_plane_grid(0.5, 2);
    const TriangleMesh mesh = joined(left, scaled_and_moved(left, 1.0, Vec3(0.5 + width, 0.0, 0.0)));
    EXPECT_EQ(adjacency_of(mesh).walkable_count() == mesh.triangles.size(), width > kMargin);
  }
}

TEST(SurfaceAdjacency, AVertexOfTooManyTrianglesIsNotWalkable) {
  EXPECT_EQ(adjacency_of(make_cylinder(0.5, 0.4, SurfaceAdjacency::kMostValence - 2, 2)).walkable_count(),
            make_cylinder(0.5, 0.4, SurfaceAdjacency::kMostValence - 2, 2).triangles.size());
  const TriangleMesh wheel = make_cylinder(0.5, 0.4, SurfaceAdjacency::kMostValence + 2, 2);
  EXPECT_LT(adjacency_of(wheel).walkable_count(), wheel.triangles.size());
}

// Against points sampled densely on both triangles.
TEST(AreApart, SaysYesOnlyWhereTheDistanceIsAboveTheMargin) {
  std::mt19937_64 random(41);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  const auto draw = [&] { return Vec3(place(random), place(random), place(random)); };
  int apart = 0;
  for (int i = 0; i < 400; ++i) {
    const std::array<Vec3, 3> a = {draw(), draw(), draw()};
    const std::array<Vec3, 3> b = {draw(), draw(), draw()};
    const double margin = 0.2;
    double least = 1e9;
    for (int u = 0; u <= 24; ++u) {
      for (int v = 0; u + v <= 24; ++v) {
        const Vec3 p = a[0] + u / 24.0 * (a[1] - a[0]) + v / 24.0 * (a[2] - a[0]);
        least = std::min(least, closest_point(b[0], b[1], b[2], p).distance);
      }
    }
    const bool says = are_apart(a, b, margin);
    if (says) {
      EXPECT_GT(least, margin) << i;
    } else {
      EXPECT_LT(least, margin + 0.1) << i;  // the samples are no farther apart than that
    }
    apart += says ? 1 : 0;
  }
  EXPECT_GT(apart, 50);
  EXPECT_LT(apart, 350);
}

}  // namespace
}  // namespace hapton
