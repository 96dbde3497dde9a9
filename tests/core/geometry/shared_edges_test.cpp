#include "core/geometry/shared_edges.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "core/geometry/mesh_topology.h"

namespace hapton {
namespace {

TEST(SharedEdges, OnAClosedSurfaceTwoTrianglesShareEachEdge) {
  const TriangleMesh mesh = make_torus(1.0, 0.3, 20, 12);
  const SharedEdges edges(mesh.triangles);
  EXPECT_EQ(edges.size(), mesh.triangles.size() * 3 / 2);
  for (std::size_t e = 0; e < edges.size(); ++e) {
    ASSERT_EQ(edges[e].size(), 2U);
    EXPECT_NE(edges[e][0].upward, edges[e][1].upward);
  }
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const HalfEdge* other = edges.adjacent(t, k);
      ASSERT_NE(other, nullptr);
      EXPECT_NE(other->triangle, t);
      EXPECT_EQ(edges.edge_of(other->triangle, other->corner), edges.edge_of(t, k));
      EXPECT_EQ(edges.adjacent(other->triangle, other->corner)->triangle, t);
    }
  }
}

TEST(SharedEdges, BoundaryAndNonManifoldEdgesHaveNoAdjacentTriangle) {
  // Three triangles share one edge; all other edges are boundary edges.
  const std::vector<Triangle> triangles = {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}};
  const SharedEdges edges(triangles);
  EXPECT_EQ(edges.size(), 7U);
  EXPECT_EQ(edges[edges.edge_of(0, 0)].size(), 3U);
  for (std::uint32_t t = 0; t < 3; ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_EQ(edges.adjacent(t, k), nullptr);
  }
}

TEST(SharedEdges, WithoutTrianglesThereAreNoEdges) { EXPECT_EQ(SharedEdges({}).size(), 0U); }

}  // namespace
}  // namespace hapton
