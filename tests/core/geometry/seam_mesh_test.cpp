#include "core/geometry/seam_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

constexpr double kSeamTolerance = 0.01;

// Two squares side by side, their common side a gap: vertices 0 to 3 left, 4 to 7 right; 1 and 4, 2 and 7 face each other.
TriangleMesh two_squares(double gap) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1 + gap, 0, 0}, {2 + gap, 0, 0}, {2 + gap, 1, 0}, {1 + gap, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  return mesh;
}

SeamMesh seam_of(TriangleMesh& mesh, double tolerance = kSeamTolerance) { return {mesh, find_boundary_vertices(mesh), tolerance}; }

TEST(SeamMesh, FindsTheBoundaryAsCountingEdgesDoes) {
  EXPECT_TRUE(find_boundary_vertices(make_icosphere(1.0, 2)).empty());
  for (const std::uint64_t seed : {1U, 2U}) {
    TriangleMesh mesh = made::soup(seed, 200, 1.0, 0.5);
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) mesh.triangles[i][2] = mesh.triangles[i * 7 % 200][0];  // non-manifold
    const std::size_t boundary = count_edges(mesh).boundary;
    TriangleMesh copy = mesh;
    EXPECT_EQ(seam_of(copy).boundary_edges().size(), boundary) << "seed " << seed;
  }
  const TriangleMesh sheet = make_plane_grid(1.0, 3);
  const std::vector<std::uint8_t> at_boundary = find_boundary_vertices(sheet);
  EXPECT_EQ(std::count(at_boundary.begin(), at_boundary.end(), std::uint8_t{1}), 12);
}

TEST(SeamMesh, WeldsTwoSidesOfAGapIntoOneEdge) {
  TriangleMesh mesh = two_squares(1e-3);
  SeamMesh seam = seam_of(mesh);
  EXPECT_EQ(seam.boundary_edges().size(), 8U);
  EXPECT_EQ(seam.weld(4, 1), SeamMesh::Weld::done);
  EXPECT_EQ(seam.zipped(), 0U);
  EXPECT_EQ(seam.weld(7, 2), SeamMesh::Weld::done);
  EXPECT_EQ(seam.zipped(), 1U);
  EXPECT_EQ(seam.boundary_edges().size(), 6U);
  EXPECT_FALSE(seam.is_boundary(1, 2));
  EXPECT_EQ(seam.representative_of(7), 2U);
  const SeamMesh::Mapping mapping = seam.finish();
  EXPECT_EQ(mesh.vertices.size(), 6U);
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}}));
  EXPECT_EQ(mapping.resulting_vertices, (std::vector<std::uint32_t>{0, 1, 2, 3, 1, 4, 5, 2}));
}

TEST(SeamMesh, RejectsWeldsThatBreakTheSurface) {
  TriangleMesh mesh = two_squares(1e-3);
  SeamMesh seam = seam_of(mesh, 10.0);
  EXPECT_EQ(seam.weld(0, 1), SeamMesh::Weld::rejected);  // the edge 0, 1 would shrink to nothing
  EXPECT_EQ(seam.weld(4, 3), SeamMesh::Weld::rejected);  // 4, 6, 7 would become 3, 6, 7, which has no area
  EXPECT_EQ(seam.weld(6, 3), SeamMesh::Weld::rejected);  // 4, 6, 7 would become 4, 3, 7, which faces down
  EXPECT_EQ(seam.boundary_edges().size(), 8U);
  SeamMesh near = seam_of(mesh, 0.5e-3);
  EXPECT_EQ(near.weld(4, 1), SeamMesh::Weld::too_far);
  // If all three corners were welded, the two triangles would be the same.
  TriangleMesh twice;
  twice.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1e-3}, {1, 0, 1e-3}, {0, 1, 1e-3}};
  twice.triangles = {{0, 1, 2}, {3, 4, 5}};
  SeamMesh plates = seam_of(twice);
  EXPECT_EQ(plates.weld(3, 0), SeamMesh::Weld::done);
  EXPECT_EQ(plates.weld(4, 1), SeamMesh::Weld::done);
  EXPECT_EQ(plates.weld(5, 2), SeamMesh::Weld::rejected);
  EXPECT_EQ(plates.boundary_edges().size(), 4U);
}

TEST(SeamMesh, RejectsAWeldThatMakesANonManifoldEdge) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {1, 0, 1e-3}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 4, 5}};
  SeamMesh seam = seam_of(mesh);
  EXPECT_EQ(seam.weld(4, 1), SeamMesh::Weld::rejected);
}

TEST(SeamMesh, SplitsAnEdgeAndUndoesTheSplit) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, -1e-3, 0}, {0.5, -1, 0}, {0, -1e-3, 0}};
  mesh.triangles = {{1, 2, 0}, {5, 4, 3}};
  const Eigen::Vector3f up = Eigen::Vector3f::UnitZ();
  const Eigen::Vector3f aside = Eigen::Vector3f::UnitX();
  mesh.authored_normals = {{aside, up, up}, {up, up, up}};
  const TriangleMesh original = mesh;
  SeamMesh seam = seam_of(mesh);
  ASSERT_TRUE(seam.split(1, 0, 3));
  EXPECT_EQ(seam.boundary_edges().size(), 7U);
  EXPECT_TRUE(seam.is_boundary(0, 3));
  EXPECT_TRUE(seam.is_boundary(3, 1));
  EXPECT_TRUE(seam.is_edge(2, 3));
  EXPECT_EQ(seam.boundary_edge(3, 1).chord, seam.boundary_edge(0, 3).chord);
  seam.unsplit(1, 0, 3);
  EXPECT_EQ(mesh.triangles, original.triangles);
  EXPECT_EQ(mesh.authored_normals, original.authored_normals);
  EXPECT_EQ(seam.boundary_edges().size(), 6U);
  EXPECT_EQ(seam.valence(3), 1U);
  EXPECT_EQ(seam.zipped(), 0U);

  ASSERT_TRUE(seam.split(0, 1, 3));
  const SeamMesh::Mapping mapping = seam.finish();
  EXPECT_EQ(mesh.triangles, (std::vector<Triangle>{{3, 2, 0}, {1, 2, 3}, {5, 4, 3}}));
  EXPECT_EQ(mapping.source_triangles, (std::vector<std::uint32_t>{0, 0, 1}));
}

TEST(SeamMesh, RejectsSplitsThatBreakTheSurface) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.25, 2, 0}, {0.5, -1, 0}, {0.5, -2, 0}, {0.5, -1, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}, {4, 5, 6}};
  SeamMesh seam = seam_of(mesh);
  EXPECT_FALSE(seam.split(0, 1, 3));  // beyond the third vertex: both parts would be flipped
  EXPECT_FALSE(seam.split(0, 1, 2));
  EXPECT_FALSE(seam.split(0, 1, 0));
  EXPECT_FALSE(seam.split(4, 5, 0));  // an edge with two triangles
  EXPECT_EQ(mesh.triangles.size(), 3U);
}

TEST(SeamMesh, DistinguishesAStripFromAGap) {
  TriangleMesh strip;
  for (int i = 0; i <= 20; ++i) strip.vertices.emplace_back(0.1 * i, i % 2 == 0 ? 0.0 : 0.005, 0.0);
  for (std::uint32_t i = 0; i + 2 <= 20; ++i) strip.triangles.push_back(i % 2 == 0 ? Triangle{i, i + 2, i + 1} : Triangle{i, i + 1, i + 2});
  const SeamMesh ribbon = seam_of(strip);
  EXPECT_TRUE(ribbon.is_joined_nearby(10, 13, Vec3(1.15, 0.0025, 0.0), 0.16));
  EXPECT_FALSE(ribbon.is_joined_nearby(0, 19, Vec3(1.0, 0.0, 0.0), 0.01));
  TriangleMesh gap = two_squares(1e-3);
  const SeamMesh squares = seam_of(gap);
  EXPECT_FALSE(squares.is_joined_nearby(1, 4, Vec3(1.0005, 0.0, 0.0), 10.0));
  EXPECT_TRUE(squares.is_triangle_joined_nearby(0, 3, Vec3(0.5, 0.5, 0.0), 0.1));
  EXPECT_FALSE(squares.is_triangle_joined_nearby(0, 7, Vec3(0.5, 0.5, 0.0), 10.0));
}

}  // namespace
}  // namespace hapton
