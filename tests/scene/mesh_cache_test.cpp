#include "scene/mesh_cache.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "scene/scene_file.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// A square of side x side squares, each of two triangles.
std::string squares_obj(int side) {
  std::string text;
  for (int y = 0; y <= side; ++y) {
    for (int x = 0; x <= side; ++x) text += fmt::format("v {} {} 0\n", x, y);
  }
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const int corner = 1 + y * (side + 1) + x;
      text += fmt::format("f {} {} {}\nf {} {} {}\n", corner, corner + 1, corner + side + 2, corner, corner + side + 2, corner + side + 1);
    }
  }
  return text;
}

TEST(MeshCaches, CountTheTrianglesOfEachObjectThoughTheyShareAMesh) {
  const ScratchFolder folder;
  constexpr int kSide = 64;
  folder.write("squares.obj", squares_obj(kSide));
  MeshCache cache(CrackSealing::off, AppearanceReading::off, AppearanceReading::off);
  ObjectSpec object;
  object.mesh = "squares.obj";
  object.unit = Unit::mm;
  object.mesh_line = 7;
  std::vector<std::string> notes;
  const std::size_t most = kMaxMeshTriangles / (2 * kSide * kSide);
  for (std::size_t n = 0; n < most; ++n) ASSERT_TRUE(cache.count(folder.path(), object, notes)) << n;
  const auto one_more = cache.count(folder.path(), object, notes);
  ASSERT_FALSE(one_more);
  EXPECT_THAT(one_more.error().what, AllOf(StartsWith("line 7: with 'squares'"), HasSubstr("67108864 triangles together")));
}

// Without the bound, a small scene file would take gigabytes of memory.
TEST(MeshCaches, ASceneWithTooManyTrianglesInAllIsRejectedBeforeAnyIsMade) {
  const ScratchFolder folder;
  folder.write("squares.obj", squares_obj(91));  // more than 2^26 / 4096 triangles
  std::string text = "[[object]]\nname = 'one'\nmesh = 'squares.obj'\nunit = 'mm'\nseal_cracks = false\n";
  for (int n = 1; n < 4096; ++n) text += fmt::format("[[instance]]\nname = 'i{}'\nof = 'one'\nposition_m = [{}, 0, 0]\n", n, n);
  const auto scene = load_scene(folder.write("a.toml", text));
  ASSERT_FALSE(scene);
  EXPECT_THAT(scene.error().what, AllOf(HasSubstr("a.toml: line 3: with 'i"), HasSubstr("use fewer objects or instances")));
  EXPECT_EQ(scene.error().what.find('\n'), std::string::npos);
}

// The images of a material may take hundreds of megabytes, so objects must not have copies of their own.
TEST(MeshCaches, ObjectsWithAMaterialOfTheirFileShareItsImages) {
  MeshHaptics haptics;
  haptics.maps.images.push_back({"images[0]", "the bytes"});
  haptics.materials.push_back({.name = "rough", .where = "materials[0]", .numbers = R"({"friction_map_range":[0.1,0.9]})"});
  haptics.materials[0].friction = 0;
  MeshCache cache(CrackSealing::off, AppearanceReading::off, AppearanceReading::off);
  const auto first = cache.find_material("a.glb", haptics, 0);
  const auto second = cache.find_material("a.glb", haptics, 0);
  ASSERT_TRUE(first && second) << (first ? second.error().what : first.error().what);
  ASSERT_NE((*first)->maps.friction.bytes, nullptr);
  const MaterialSpec copy = **second;
  EXPECT_EQ(copy.maps.friction.bytes, (*first)->maps.friction.bytes);
  EXPECT_EQ(*copy.maps.friction.bytes, "the bytes");
}

}  // namespace
}  // namespace hapton
