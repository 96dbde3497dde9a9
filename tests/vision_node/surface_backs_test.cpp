#include "vision_node/surface_backs.h"

#include <gtest/gtest.h>

#include <utility>

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

TEST(SurfaceBacks, OfWhatIsInsideOutAreSeen) {
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
  MeshLook look;
  look.materials.push_back({.name = "glass", .alpha_mode = AlphaMode::blend, .alpha = 0.5F});
  object.look = std::make_shared<const MeshLook>(look);
  EXPECT_FALSE(shows_backs(object));
  look.materials[0].is_double_sided = true;
  object.look = std::make_shared<const MeshLook>(look);
  EXPECT_TRUE(shows_backs(object));
  look.materials[0].alpha_mode = AlphaMode::opaque;
  object.look = std::make_shared<const MeshLook>(look);
  EXPECT_FALSE(shows_backs(object)) << "nothing shows them";
}

}  // namespace
}  // namespace hapton
