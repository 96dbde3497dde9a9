#include "scene/mesh_haptics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::uint32_t kNoMaterial = TriangleAppearance::kNoMaterial;

TEST(MeshHaptics, TellsWhichMaterialsOccur) {
  EXPECT_THAT(list_haptic_materials({}), IsEmpty());
  const MeshAppearance maps = {
      .images = {}, .materials = {}, .triangles = {{.material = 2}, {.material = kNoMaterial}, {.material = 2}, {.material = 0}}};
  EXPECT_THAT(list_haptic_materials(maps), ElementsAre(2, kNoMaterial, 0));
}

TEST(MeshHaptics, KeepsTheTrianglesOfOne) {
  TriangleMesh mesh = {.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 0}}, .triangles = {{0, 1, 2}, {3, 1, 2}, {0, 1, 3}}};
  MeshAppearance appearance = {.images = {}, .materials = {}, .triangles = {{.material = 7}, {.material = 8}, {.material = 9}}};
  MeshAppearance maps = {.images = {}, .materials = {}, .triangles = {{.material = 0}, {.material = 1}, {.material = 0}}};
  TriangleMesh other = mesh;
  MeshAppearance no_appearance;
  MeshAppearance other_maps = maps;
  keep_haptic_material(1, mesh, appearance, maps);
  ASSERT_EQ(mesh.triangles.size(), 1U);
  EXPECT_EQ(mesh.vertices.size(), 3U);
  EXPECT_EQ(mesh.corner(0, 0), Vec3(5, 0, 0));
  EXPECT_EQ(appearance.triangles.at(0).material, 8U);
  EXPECT_EQ(maps.triangles.size(), 1U);
  keep_haptic_material(0, other, no_appearance, other_maps);
  EXPECT_EQ(other.triangles.size(), 2U);
  EXPECT_THAT(no_appearance.triangles, IsEmpty());
  const TriangleMesh before = other;
  keep_haptic_material(0, other, no_appearance, other_maps);
  EXPECT_EQ(other.vertices, before.vertices) << "all of one material: nothing changes";
}

}  // namespace
}  // namespace hapton
