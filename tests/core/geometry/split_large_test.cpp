#include "core/geometry/split_large.h"

#include <gtest/gtest.h>

#include "core/geometry/corner_normals.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/smooth_surface.h"
#include "tests/core/geometry/smooth_faces.h"
#include "tests/support/obj_mesh.h"

namespace hapton {
namespace {

TEST(SplitLarge, SplittingKeepsTheSurfaceAndClosesNoCrack) {
  for (const TriangleMesh& mesh :
       {make_box(Vec3(1, 1, 1)), make_cylinder(0.02, 1.0, 24), make_gutter(1.0, 0.5, 1.0, 1), made::obj_mesh("wingnut.obj")}) {
    SmoothSurfaceReport report;
    const auto surface = make_smooth_surface(mesh, {.longest_edge = 0.02, .growth = 1000.0}, report);
    ASSERT_TRUE(surface);
    const TriangleMesh split = faces_of(*surface);
    EXPECT_GT(report.split.triangles, 0U);
    EXPECT_TRUE(report.split.complete);
    EXPECT_TRUE(count_edges(split).closed());
    EXPECT_NEAR(compute_volume(split), compute_volume(mesh), 1e-9 * std::fabs(compute_volume(mesh)));
    EXPECT_NEAR(compute_area(split), compute_area(mesh), 1e-9 * compute_area(mesh));
    for (std::size_t t = 0; t < split.triangles.size(); ++t) {
      for (int k = 0; k < 3; ++k) EXPECT_LE((split.corner(t, k) - split.corner(t, (k + 1) % 3)).norm(), report.split.longest_edge);
      EXPECT_LT(surface->mesh.source[t], mesh.triangles.size());
    }
  }
}

TEST(SplitLarge, SplittingStopsAtItsLimitAndSaysSo) {
  SmoothSurfaceReport report;
  const auto surface = make_smooth_surface(make_icosphere(1.0, 6), {.longest_edge = 1e-4, .growth = 1.0}, report);
  ASSERT_TRUE(surface);
  EXPECT_FALSE(report.split.complete);
  EXPECT_LE(surface->face_count, 81920U + 100000U);  // `growth` times the triangles, plus 100,000
  EXPECT_NE(report.split.describe().find("limit"), std::string::npos);
}

// On a sphere whose corners have its normals, the normal at the middle of an edge is that of the sphere too.
TEST(SplitLarge, NewVerticesAndNormalsAreTheMeansOfTheTwoThatTheListsName) {
  const TriangleMesh sphere = make_icosphere(1.0, 2);
  CornerNormalReport report;
  ShadedMesh mesh = fill_corner_normals(sphere, std::vector<std::uint32_t>(sphere.triangles.size(), 0), 1.0, report);
  mesh.normals = mesh.vertices;
  mesh.corner_normals = mesh.triangles;
  const std::size_t before = mesh.vertices.size();
  const SplitReport split = split_large(mesh, 0.2, 1 << 20);
  const std::size_t edges = 3 * sphere.triangles.size() / 2;
  ASSERT_EQ(split.edges, edges) << "each is halved once";
  EXPECT_EQ(split.triangles, 3 * sphere.triangles.size());
  ASSERT_EQ(mesh.vertices.size(), before + edges);
  ASSERT_EQ(mesh.normals.size(), before + edges);
  ASSERT_EQ(mesh.middle_vertices.size(), edges);
  ASSERT_EQ(mesh.middle_normals.size(), edges);
  EXPECT_EQ(mesh.first_middle_normal, before);
  for (std::size_t e = 0; e < edges; ++e) {
    const auto [a, b] = mesh.middle_vertices[e];
    EXPECT_EQ(mesh.vertices[before + e], Vec3(0.5 * mesh.vertices[a] + 0.5 * mesh.vertices[b]));
    EXPECT_EQ(mesh.normals[before + e], middle_normal_of(mesh, mesh.middle_normals[e]));
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((mesh.normal(t, k) - mesh.corner(t, k).normalized()).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace hapton
