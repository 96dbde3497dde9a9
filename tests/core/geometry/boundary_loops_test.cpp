#include "core/geometry/boundary_loops.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <utility>

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
  // The triangles whose middles are beyond a plane were removed, so the rim deviates from a circle in that plane by at most an edge.
  const double edge = 0.07;
  for (const auto& [loop, plane] : {std::pair{loops[0], 0.45}, std::pair{loops[1], 0.48}}) {
    const double diameter = 2.0 * std::sqrt(0.25 - plane * plane);
    EXPECT_GT(loop.width, diameter - edge);
    EXPECT_LT(loop.width, diameter + edge);
  }
}

// A round hole that continues in a slot, in a tilted plate: a ball of nearly the hole's diameter fits through.
TEST(BoundaryLoops, ASlotDoesNotMakeAHoleNarrower) {
  TriangleMesh plate;
  const Quat tilt = Quat::FromTwoVectors(Vec3::UnitZ(), Vec3(1, 2, 3));
  std::vector<Vec3> rim;
  constexpr int kEdges = 64;
  for (int n = 1; n < kEdges; ++n) {
    const double angle = 2.0 * M_PI * n / kEdges;
    rim.emplace_back(0.005 * std::cos(angle), 0.005 * std::sin(angle), 0.0);
  }
  rim.emplace_back(0.045, -0.00049, 0.0);
  rim.emplace_back(0.045, 0.00049, 0.0);
  for (const Vec3& p : rim) {
    plate.vertices.push_back(tilt * p);
    plate.vertices.push_back(tilt * Vec3(4.0 * p + Vec3(0, 0, 0.02)));
  }
  const auto count = static_cast<std::uint32_t>(rim.size());
  for (std::uint32_t n = 0; n < count; ++n) {
    const std::uint32_t next = (n + 1) % count;
    plate.triangles.push_back({2 * n, 2 * n + 1, 2 * next});
    plate.triangles.push_back({2 * next, 2 * n + 1, 2 * next + 1});
  }
  const auto loops = find_boundary_loops(plate);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_NEAR(loops[1].width, 0.01, 0.0003);
  EXPECT_NEAR(loops[0].width, 0.04, 0.0012);
  EXPECT_LE(find_boundary_loops(plate, 0.05)[0].width, 0.05);
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

TEST(BoundaryLoops, ATriangleThatRepeatsAVertexJoinsNoPieces) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 4, 0), Vec3(9, 9, 9), Vec3(10, 9, 9), Vec3(9, 10, 9)};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {2, 3, 3}};
  const auto loops = find_boundary_loops(mesh);
  ASSERT_EQ(loops.size(), 2U);
  EXPECT_DOUBLE_EQ(loops[0].piece_area, 6.0);
  EXPECT_DOUBLE_EQ(loops[1].piece_area, 0.5);
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
