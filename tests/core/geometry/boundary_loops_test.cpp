#include "core/geometry/boundary_loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/mesh_shapes.h"
#include "core/geometry/mesh_topology.h"

namespace hapton {
namespace {

TEST(BoundaryLoops, AClosedMeshHasNone) {
  EXPECT_TRUE(find_boundary_loops(make_icosphere(0.5, 3)).empty());
  EXPECT_TRUE(find_boundary_loops(make_box(Vec3(1, 2, 3), 4)).empty());
  EXPECT_TRUE(find_boundary_loops(TriangleMesh{}).empty());
}

TEST(BoundaryLoops, TheRimOfASheetIsNoOpening) {
  const auto loops = find_boundary_loops(scaled_and_moved(make_plane_grid(1.0, 5), 1.0, Vec3(100, 200, 300)));
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].edges, 20U);
  EXPECT_NEAR(loops[0].length, 4.0, 1e-9);
  EXPECT_NEAR(loops[0].area, 1.0, 1e-9);
  EXPECT_NEAR(loops[0].piece_area, 1.0, 1e-9);
  EXPECT_NEAR((loops[0].centre - Vec3(100, 200, 300)).norm(), 0.0, 1e-9);
  EXPECT_FALSE(loops[0].is_opening());
}

TEST(BoundaryLoops, OpeningsOfABallAreFoundTheWidestFirst) {
  TriangleMesh ball = make_icosphere(0.5, 4);
  std::erase_if(ball.triangles, [&](const Triangle& t) {
    const Vec3 middle = (ball.vertices[t[0]] + ball.vertices[t[1]] + ball.vertices[t[2]]) / 3.0;
    return middle.z() > 0.48 || middle.x() < -0.45;
  });
  const auto loops = find_boundary_loops(ball);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_TRUE(loops[0].is_opening() && loops[1].is_opening());
  EXPECT_LT(loops[0].centre.x(), -0.4);
  EXPECT_GT(loops[1].centre.z(), 0.45);
  // A round opening's width is its diameter; the rim is jagged.
  EXPECT_NEAR(loops[0].width(), 2.0 * std::sqrt(0.25 - 0.45 * 0.45), 0.12);
  EXPECT_NEAR(loops[1].width(), 2.0 * std::sqrt(0.25 - 0.48 * 0.48), 0.12);
}

TEST(BoundaryLoops, ATriangleOfItsOwnIsItsOwnRim) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 4, 0), Vec3(9, 9, 9)};
  mesh.triangles = {{0, 1, 2}, {3, 3, 0}};
  const auto loops = find_boundary_loops(mesh);
  ASSERT_EQ(loops.size(), 1U);
  EXPECT_EQ(loops[0].edges, 3U);
  EXPECT_DOUBLE_EQ(loops[0].length, 12.0);
  EXPECT_DOUBLE_EQ(loops[0].area, 6.0);
  EXPECT_EQ(loops[0].on_edge, Vec3(1.5, 2, 0));
  EXPECT_FALSE(loops[0].is_opening());
}

TEST(BoundaryLoops, InconsistentEdgesAreThoseThatTopologyCounts) {
  TriangleMesh ball = make_icosphere(0.5, 3);
  EXPECT_TRUE(find_inconsistent_edges(ball).empty());
  for (const std::size_t flipped : {3U, 77U, 200U}) std::swap(ball.triangles[flipped][0], ball.triangles[flipped][1]);
  const auto edges = find_inconsistent_edges(ball);
  EXPECT_EQ(edges.size(), 9U);
  EXPECT_EQ(edges.size(), compute_mesh_topology(ball).inconsistent_edges);
  const Vec3 first = (ball.corner(3, 0) + ball.corner(3, 1) + ball.corner(3, 2)) / 3.0;
  EXPECT_TRUE(std::any_of(edges.begin(), edges.end(), [&](const Vec3& p) { return (p - first).norm() < 0.1; }));
}

}  // namespace
}  // namespace hapton
