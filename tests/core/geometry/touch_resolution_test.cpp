#include "core/geometry/touch_resolution.h"

#include <gtest/gtest.h>

#include "core/geometry/cracked_shapes.h"
#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/seam_mesh.h"

namespace hapton {
namespace {

TEST(TouchResolution, ASoundMeshNeedsNothing) {
  EXPECT_FALSE(resolve_for_touch(make_icosphere(0.1, 3), 1e-9, 1e-12).has_value());
  EXPECT_FALSE(resolve_for_touch({}, 1e-9, 1e-12).has_value());
}

TEST(TouchResolution, RemovesCopiesAndTrianglesWithoutArea) {
  TriangleMesh mesh = make_icosphere(0.1, 2);
  const auto sound_triangles = mesh.triangles.size();
  mesh.triangles.push_back({mesh.triangles[3][1], mesh.triangles[3][2], mesh.triangles[3][0]});  // the same, starting at another vertex
  mesh.triangles.push_back({5, 5, 9});
  const Vec3 middle = 0.5 * (mesh.corner(7, 0) + mesh.corner(7, 1));
  mesh.vertices.push_back(middle);
  mesh.triangles.push_back({mesh.triangles[7][0], mesh.triangles[7][1], static_cast<std::uint32_t>(mesh.vertices.size() - 1)});
  const auto resolved = resolve_for_touch(mesh, 1e-9, 1e-12);
  ASSERT_TRUE(resolved.has_value());
  EXPECT_EQ(resolved->triangles.size(), sound_triangles);
}

TEST(TouchResolution, AFlippedCopyStays) {
  TriangleMesh sheet;
  sheet.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  sheet.triangles = {{0, 1, 2}, {0, 2, 1}};
  EXPECT_FALSE(resolve_for_touch(sheet, 1e-9, 1e-12).has_value());
}

// A triangle without area joins an edge to its two halves. It is removed, and the triangle at the edge is split instead.
TEST(TouchResolution, AFillerOfATJunctionIsReplacedByASplit) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(1, 1, 0), Vec3(1, 0, 0), Vec3(0.5, -1, 0), Vec3(1.5, -1, 0)};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 4, 3}, {3, 5, 1}, {3, 4, 5}};
  const auto resolved = resolve_for_touch(mesh, 1e-8, 1e-11);
  ASSERT_TRUE(resolved.has_value());
  EXPECT_EQ(resolved->triangles.size(), 5U);
  for (const Triangle& t : resolved->triangles) EXPECT_FALSE(t == (Triangle{0, 1, 2}));
}

// Removing a thin triangle at a boundary would leave a slit there.
TEST(TouchResolution, AThinTriangleWithAGapThatCannotBeSealedStays) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0.5, -1e-10, 0), Vec3(0.5, 1, 0)};
  mesh.triangles = {{0, 1, 3}, {0, 2, 1}};
  EXPECT_FALSE(resolve_for_touch(mesh, 1e-9, 1e-12).has_value());
}

TEST(TouchResolution, RemovesAThinTriangleBetweenOthers) {
  TriangleMesh mesh = make_icosphere(0.1, 2);
  const auto sound_triangles = mesh.triangles.size();
  const Triangle first = mesh.triangles[0];
  const auto middle = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.push_back(0.5 * (mesh.vertices[first[0]] + mesh.vertices[first[1]]) + Vec3(1e-11, 0, 0));
  mesh.triangles[0] = {first[0], middle, first[2]};
  mesh.triangles.push_back({middle, first[1], first[2]});
  mesh.triangles.push_back({first[0], first[1], middle});
  const auto resolved = resolve_for_touch(mesh, 1e-9, 1e-13);
  ASSERT_TRUE(resolved.has_value());
  EXPECT_EQ(resolved->triangles.size(), sound_triangles + 2);  // the neighbour is split instead
  EXPECT_TRUE(find_boundary_vertices(*resolved).empty());
}

TEST(TouchResolution, CracksFinerThanTheResolutionAreSealedAndWiderOnesStay) {
  const TriangleMesh cracked = make_torn(make_icosphere(0.1, 3), 1e-10);
  EXPECT_TRUE(resolve_for_touch(cracked, 1e-9, 1e-12).has_value());
  EXPECT_FALSE(resolve_for_touch(cracked, 1e-12, 1e-14).has_value());
}

}  // namespace
}  // namespace hapton
