#include "vision_node/back_face_visibility.h"

#include <gtest/gtest.h>

#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr Triangle kTetrahedron[] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}};

void add_tetrahedron(TriangleMesh& mesh, const Vec3& corner, double size) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) mesh.vertices.push_back(corner + size * p);
  for (const Triangle& t : kTetrahedron) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

void turn_inside_out(TriangleMesh& mesh) {
  for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

SceneObject object_of(TriangleMesh mesh) {
  SceneObject object;
  object.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
  return object;
}

TriangleMesh make_tetrahedron() {
  TriangleMesh mesh;
  add_tetrahedron(mesh, Vec3::Zero(), 0.1);
  return mesh;
}

// One mesh has a closed body and an open sheet: the backs of the sheet are drawn, those of the body are not.
TEST(SurfaceBacks, ClustersOfClosedBodiesAreLeftOutWhereBacksAreDrawn) {
  TriangleMesh mesh = make_icosphere(0.1, 3);
  const std::size_t ball_triangles = mesh.triangles.size();
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {Vec3(5, 0, 0), Vec3(6, 0, 0), Vec3(5, 1, 0)});
  mesh.triangles.push_back({first, first + 1, first + 2});
  DetailLevel level = make_full_level(mesh, make_detail_frame(mesh));
  mark_without_back(mesh, nullptr, level);
  ASSERT_EQ(level.without_back.size(), first + 3);
  for (std::uint32_t v = 0; v < first + 3; ++v) EXPECT_EQ(level.without_back[v], v < first ? 1 : 0);
  divide_into_clusters(level);
  std::size_t hidden_triangles = 0;
  for (const DetailCluster& cluster : level.clusters) {
    if (cluster.shows_backs) continue;
    hidden_triangles += cluster.count / 3;
    for (std::uint32_t i = cluster.first; i < cluster.first + cluster.count; ++i) EXPECT_EQ(level.without_back[level.indices[i]], 1);
  }
  EXPECT_GT(static_cast<double>(hidden_triangles),
            0.9 * static_cast<double>(ball_triangles));  // the sheet's cluster may contain some triangles of the body
  MeshAppearance appearance;
  appearance.materials.push_back({.name = "glass", .alpha_mode = AlphaMode::blend, .is_double_sided = true});
  DetailLevel with_glass = make_full_level(mesh, make_detail_frame(mesh));
  mark_without_back(mesh, &appearance, with_glass);
  EXPECT_TRUE(with_glass.without_back.empty()) << "its inner sides are seen";
}

TEST(SurfaceBacks, OfClosedBodiesAreAlwaysHidden) {
  TriangleMesh mesh = make_tetrahedron();
  EXPECT_FALSE(shows_backs(object_of(mesh)));
  add_tetrahedron(mesh, Vec3(1, 0, 0), 0.1);
  EXPECT_FALSE(shows_backs(object_of(mesh)));
}

TEST(SurfaceBacks, OfOpenSurfacesAreSeen) {
  TriangleMesh mesh = make_tetrahedron();
  mesh.triangles.pop_back();
  EXPECT_TRUE(shows_backs(object_of(mesh)));
  TriangleMesh mixed = make_tetrahedron();
  add_tetrahedron(mixed, Vec3(1, 0, 0), 0.1);
  mixed.triangles.pop_back();
  EXPECT_TRUE(shows_backs(object_of(mixed))) << "one of two bodies is open";
}

TEST(SurfaceBacks, OfInsideOutBodiesAreSeen) {
  TriangleMesh mesh = make_tetrahedron();
  turn_inside_out(mesh);
  EXPECT_TRUE(shows_backs(object_of(mesh)));
  TriangleMesh flipped = make_tetrahedron();
  std::swap(flipped.triangles[0][1], flipped.triangles[0][2]);
  EXPECT_TRUE(shows_backs(object_of(flipped))) << "one triangle only";
}

TEST(SurfaceBacks, AreNotSeenWhereTheyAreNotFelt) {
  TriangleMesh mesh = make_tetrahedron();
  mesh.triangles.pop_back();
  SceneObject object = object_of(mesh);
  object.material.two_sided = false;
  EXPECT_FALSE(shows_backs(object));
}

TEST(SurfaceBacks, AreSeenThroughAGlassThatItsFileShowsFromBothSides) {
  SceneObject object = object_of(make_tetrahedron());
  MeshAppearance appearance;
  appearance.materials.push_back({.name = "glass", .alpha_mode = AlphaMode::blend, .alpha = 0.5F});
  object.appearance = std::make_shared<const MeshAppearance>(appearance);
  EXPECT_FALSE(shows_backs(object));
  appearance.materials[0].is_double_sided = true;
  object.appearance = std::make_shared<const MeshAppearance>(appearance);
  EXPECT_TRUE(shows_backs(object));
  appearance.materials[0].alpha_mode = AlphaMode::opaque;
  object.appearance = std::make_shared<const MeshAppearance>(appearance);
  EXPECT_FALSE(shows_backs(object)) << "nothing shows them";
}

}  // namespace
}  // namespace hapton
