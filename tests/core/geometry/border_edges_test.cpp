#include "core/geometry/border_edges.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// Every triangle with vertices of its own, drawn towards its middle by a share of the way.
TriangleMesh torn(const TriangleMesh& mesh, double share) {
  TriangleMesh apart;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3 middle = (mesh.corner(i, 0) + mesh.corner(i, 1) + mesh.corner(i, 2)) / 3.0;
    const auto at = static_cast<std::uint32_t>(apart.vertices.size());
    for (int k = 0; k < 3; ++k) apart.vertices.push_back(mesh.corner(i, k) + share * (middle - mesh.corner(i, k)));
    apart.triangles.push_back({at, at + 1, at + 2});
  }
  return apart;
}

TEST(BorderEdges, AClosedMeshHasNone) {
  const BorderEdges count = count_border_edges(make_icosphere(0.05, 2), 1e-4);
  EXPECT_EQ(count.open + count.cracks, 0U);
}

TEST(BorderEdges, OfASheetAreOpen) {
  const BorderEdges count = count_border_edges(make_plane_grid(0.1, 8), 1e-4);
  EXPECT_EQ(count.open, 32U);
  EXPECT_EQ(count.cracks, 0U);
}

TEST(BorderEdges, OfABodyTornApartAreCracks) {
  const TriangleMesh ball = make_icosphere(0.05, 2);
  const BorderEdges count = count_border_edges(torn(ball, 1e-6), 1e-4);
  EXPECT_EQ(count.cracks, 3 * ball.triangles.size());
  EXPECT_EQ(count.open, 0U);
}

TEST(BorderEdges, WiderThanTheWidthAreOpen) {
  const TriangleMesh ball = make_icosphere(0.05, 2);
  EXPECT_EQ(count_border_edges(torn(ball, 0.1), 1e-5).cracks, 0U);
}

// The neighbour has the edge in two halves.
TEST(BorderEdges, OfATJunctionAreCracks) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0.5, 1, 0}, {0.5, 0, 0}, {0.5, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 4, 3}, {3, 4, 1}};
  const BorderEdges count = count_border_edges(mesh, 1e-3);
  EXPECT_EQ(count.cracks, 3U);
  EXPECT_EQ(count.open, 4U);
}

TEST(BorderEdges, AreTheSameFarFromTheOriginAndAtAnyScale) {
  TriangleMesh mesh = torn(make_icosphere(0.05, 1), 1e-4);
  for (Vec3& v : mesh.vertices) v = 1e-3 * v + Vec3(10.0, -10.0, 10.0);
  EXPECT_EQ(count_border_edges(mesh, 1e-7).open, 0U);
}

TEST(BorderEdges, TakeNoNoticeOfTrianglesThatRepeatAVertex) {
  TriangleMesh mesh = make_icosphere(0.05, 1);
  mesh.triangles.push_back({0, 0, 1});
  const BorderEdges count = count_border_edges(mesh, 1e-4);
  EXPECT_EQ(count.open + count.cracks, 0U);
}

}  // namespace
}  // namespace hapton
