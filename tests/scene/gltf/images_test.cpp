// Images of glTF files: how textures and parts share them, and which note a missing or unusable one causes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <string>

#include "core/geometry/mesh_shapes.h"
#include "scene/gltf/reader.h"
#include "scene/scene_file.h"
#include "tests/scene/gltf/gltf_samples.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::size_t kImageBytes = 10'000;

// JSON objects with these members, separated by commas. In each, N is replaced by its index.
std::string numbered_list(std::size_t count, const std::string& members) {
  std::string list;
  for (std::size_t n = 0; n < count; ++n) {
    std::string entry = members;
    if (const auto at = entry.find('N'); at != std::string::npos) entry.replace(at, 1, std::to_string(n));
    list += (list.empty() ? "{" : ",{") + entry + "}";
  }
  return list;
}

// Reads a file with `count` images, each with its own texture and material. image: the JSON members of each image.
RawMesh read_images(std::size_t count, const std::string& image, const std::filesystem::path& folder = ".") {
  const TriangleMesh mesh = sample::tetrahedron();
  sample::Pieces pieces;
  pieces.add(sample::positions_of(mesh));
  pieces.add(sample::indices_of(mesh));
  pieces.add(std::string(kImageBytes, 'x'));
  const std::string rest = R"("images":[)" + numbered_list(count, image) + R"(],"textures":[)" + numbered_list(count, R"("source":N)") +
                           R"(],"materials":[)" + numbered_list(count, R"("pbrMetallicRoughness":{"baseColorTexture":{"index":N}})") +
                           "]," + sample::kOneNode;
  const auto raw = read_glb(pieces.glb(sample::accessors_of(mesh), rest), folder, kMaxMeshTriangles, AppearanceReading::on);
  EXPECT_TRUE(raw) << raw.error().what;
  return raw ? *raw : RawMesh();
}

std::size_t count_bytes(const RawMesh& raw) {
  std::size_t bytes = 0;
  for (const TextureImage& image : raw.appearance.images) bytes += image.bytes.size();
  return bytes;
}

TEST(GltfImages, MayShareABufferViewAFewTimes) {
  const RawMesh few = read_images(4, R"("bufferView":2)");
  EXPECT_THAT(few.notes, IsEmpty());
  EXPECT_THAT(few.appearance.images, SizeIs(4));
  EXPECT_EQ(few.appearance.images[3].bytes, std::string(kImageBytes, 'x'));
  const RawMesh many = read_images(1000, R"("bufferView":2)");
  EXPECT_LE(count_bytes(many), 9 * kImageBytes) << "a hostile file needs only a few bytes for each such image";
  EXPECT_THAT(many.appearance.materials, SizeIs(1000));
  EXPECT_THAT(many.notes, AllOf(SizeIs(1000 - many.appearance.images.size()),
                                Each(AllOf(HasSubstr("a texture is missing: images["), HasSubstr("more than 8 times the 10")))));
}

// Otherwise each part of a large assembly would store, decode and draw with the images of all other parts.
TEST(GltfImages, PartsInASceneKeepThoseThatTheyUse) {
  const TriangleMesh mesh = sample::tetrahedron();
  sample::Pieces pieces;
  pieces.add(sample::positions_of(mesh));
  pieces.add(sample::indices_of(mesh));
  for (const char byte : {'x', 'y', 'z'}) pieces.add(std::string(kImageBytes, byte));
  const std::string primitive = R"("primitives":[{"attributes":{"POSITION":0},"indices":1,"material":)";
  const std::string rest = R"("images":[{"bufferView":2},{"bufferView":3},{"bufferView":4}],"textures":[)" +
                           numbered_list(3, R"("source":N)") + R"(],"materials":[)" +
                           numbered_list(3, R"("pbrMetallicRoughness":{"baseColorTexture":{"index":N}})") +
                           R"(],"nodes":[{"children":[1,2]},{"mesh":0,"name":"one"},{"mesh":1,"name":"two"}],"meshes":[{)" + primitive +
                           "0}]},{" + primitive + "2}]}]";
  ScratchFolder folder;
  folder.write("a.glb", pieces.glb(sample::accessors_of(mesh), rest));
  const auto scene =
      load_scene(folder.write("a.toml", "[[object]]\nmesh = 'a.glb'\npart = 'one'\n[[object]]\nmesh = 'a.glb'\npart = 'two'\n"),
                 {.sealing = CrackSealing::off, .appearance = AppearanceReading::on});
  ASSERT_TRUE(scene) << scene.error().what;
  ASSERT_EQ(scene->objects.size(), 2U);
  for (const std::size_t used_image : {0U, 2U}) {
    const auto& appearance = scene->objects[used_image / 2].appearance;
    ASSERT_NE(appearance, nullptr);
    ASSERT_EQ(appearance->images.size(), 3U);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(appearance->images[i].bytes.size(), i == used_image ? kImageBytes : 0U) << i;
      EXPECT_EQ(appearance->materials[i].image.has_value(), i == used_image) << i;
    }
    EXPECT_EQ(appearance->triangles.at(0).material, used_image) << "the numbers stay";
  }
}

TEST(GltfImages, OneFileBesideIsReadOnce) {
  ScratchFolder folder;
  folder.write("a.png", std::string(kImageBytes, 'y'));
  const RawMesh same = read_images(50, R"("uri":"a.png")", folder.path());
  EXPECT_THAT(same.notes, IsEmpty());
  EXPECT_EQ(count_bytes(same), kImageBytes);
  EXPECT_EQ(same.appearance.materials[49].image, 0U);
}

TEST(GltfImages, MayBeInlineAndHaveEscapedNames) {
  EXPECT_EQ(read_images(1, R"("uri":"data:image/png;base64,eHl6")").appearance.images.at(0).bytes, "xyz");
  ScratchFolder folder;
  folder.write("a Zz.png", "beside");
  EXPECT_EQ(read_images(1, R"("uri":"a%20%5A%7a.png")", folder.path()).appearance.images.at(0).bytes, "beside");
}

// A note says why an image is missing, and the mesh is read.
TEST(GltfImages, WhatCannotBeReadIsNamed) {
  const auto note_of = [](const std::string& image) {
    const RawMesh raw = read_images(1, image);
    EXPECT_THAT(raw.appearance.images, IsEmpty());
    EXPECT_FALSE(raw.appearance.materials.at(0).image.has_value());
    return raw.notes.size() == 1 ? raw.notes[0] : std::to_string(raw.notes.size()) + " notes";
  };
  EXPECT_EQ(note_of(R"("uri":"https://a.b/c.png")"), "a texture is missing: images[0] is on the network (https://a.b/c.png)");
  EXPECT_EQ(note_of(R"("uri":"data:image/png,xyz")"), "a texture is missing: images[0] is inline but not base64");
  EXPECT_THAT(note_of(R"("uri":"data:image/png;base64,x!")"), HasSubstr("a texture is missing: images[0] is not base64"));
  EXPECT_EQ(note_of(R"("mimeType":"image/png")"), "a texture is missing: images[0] has neither a uri nor a buffer view");
}

// The notes of a tetrahedron with this material, and textures of which only the first has an image.
std::vector<std::string> notes_of_material(const std::string& material) {
  const TriangleMesh mesh = sample::tetrahedron();
  sample::Pieces pieces;
  pieces.add(sample::positions_of(mesh));
  pieces.add(sample::indices_of(mesh));
  pieces.add("xyz");
  const std::string rest =
      R"("images":[{"bufferView":2}],"textures":[{"source":0},{}],"materials":[{)" + material + "}]," + sample::kOneNode;
  const auto raw = read_glb(pieces.glb(sample::accessors_of(mesh), rest), ".", kMaxMeshTriangles, AppearanceReading::with_normals);
  EXPECT_TRUE(raw) << raw.error().what;
  return raw ? raw->notes : std::vector<std::string>();
}

TEST(GltfImages, MaterialsThatCannotUseOneSayWhy) {
  using ::testing::Contains;
  EXPECT_THAT(notes_of_material(R"("pbrMetallicRoughness":{"baseColorTexture":{"index":1}})"),
              Contains("a texture is missing: textures[1] has no PNG or JPEG image"));
  EXPECT_THAT(notes_of_material(R"("normalTexture":{"index":0,"scale":"x"})"),
              Contains("materials[0].normalTexture.scale is not a finite number: it cannot be felt"));
  EXPECT_THAT(
      notes_of_material(R"("pbrMetallicRoughness":{"baseColorTexture":{"index":0,"extensions":)"
                        R"({"KHR_texture_transform":{"rotation":"x"}}}})"),
      Contains(AllOf(HasSubstr("a texture may be misplaced: "), HasSubstr("KHR_texture_transform.rotation is not a finite number"))));
}

}  // namespace
}  // namespace hapton
