#include "vision_node/texture_layers.h"

#include <array>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/vision_node/made_images.h"
#include "tests/vision_node/made_views.h"

namespace hapton {
namespace {

std::string make_plain_png(int width, int height, const Eigen::Vector3i& colour) {
  return make_image<vtkPNGWriter>(width, height, [&](int, int) { return colour; });
}

struct TextureLayersTest : testing::Test {
  // Opens a view, which makes an OpenGL context current for the layers.
  void SetUp() override {
    view = open_or_fail(plain_settings(StereoMode::mono, 64, 64), {});
    ASSERT_TRUE(view);
  }
  std::unique_ptr<TextureLayers> make() { return TextureLayers::make(appearance, notes); }
  // Adds the image, and a material that uses it.
  void add_image(std::string bytes) {
    appearance.materials.push_back({.name = "", .colour = {}, .image = appearance.images.size()});
    appearance.images.push_back({"image " + std::to_string(appearance.images.size()), std::move(bytes)});
  }
  std::array<int, 3> size_of(const TextureLayers& layers) {
    std::array<int, 3> size = {};
    layers.bind();
    glGetTexLevelParameteriv(GL_TEXTURE_2D_ARRAY, 0, GL_TEXTURE_WIDTH, &size[0]);
    glGetTexLevelParameteriv(GL_TEXTURE_2D_ARRAY, 0, GL_TEXTURE_HEIGHT, &size[1]);
    glGetTexLevelParameteriv(GL_TEXTURE_2D_ARRAY, 0, GL_TEXTURE_DEPTH, &size[2]);
    TextureLayers::unbind();
    return size;
  }
  // All texels, four bytes each: layer by layer, and in a layer row by row.
  std::vector<std::uint8_t> texels_of(const TextureLayers& layers) {
    const auto [width, height, depth] = size_of(layers);
    std::vector<std::uint8_t> texels(static_cast<std::size_t>(4) * width * height * depth);
    layers.bind();
    glGetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels.data());
    TextureLayers::unbind();
    return texels;
  }

  std::unique_ptr<StereoView> view;
  MeshAppearance appearance;
  std::vector<std::string> notes;
};

TEST_F(TextureLayersTest, WithoutAnImageThatIsUsedThereAreNone) {
  appearance.images.push_back({"unused", make_plain_png(2, 2, {255, 0, 0})});
  EXPECT_EQ(make(), nullptr);
  appearance.materials.push_back({.name = "", .colour = {}, .image = 7});
  EXPECT_EQ(make(), nullptr) << "an image that the appearance does not have";
  EXPECT_TRUE(notes.empty());
}

TEST_F(TextureLayersTest, EachUsedImageThatCanBeReadIsALayer) {
  appearance.images.push_back({"unused", make_plain_png(32, 32, {255, 255, 255})});
  add_image(make_plain_png(8, 2, {0, 0, 255}));
  add_image("no image");
  add_image(make_plain_png(2, 4, {0, 255, 0}));
  const auto layers = make();
  ASSERT_TRUE(layers);
  EXPECT_EQ(layers->layer_of(), (std::vector<std::uint8_t>{0, 1, 0, 2}));
  ASSERT_EQ(notes.size(), 1U);
  EXPECT_NE(notes[0].find("image 2"), std::string::npos) << notes[0];
  EXPECT_EQ(size_of(*layers), (std::array<int, 3>{8, 4, 2})) << "the largest image decides, each side for itself";
  const std::vector<std::uint8_t> texels = texels_of(*layers);
  for (std::size_t i = 0; i < 8 * 4; ++i) {
    ASSERT_EQ(texels[4 * i], 0) << i;
    ASSERT_EQ(texels[4 * i + 1], 0) << i;
    ASSERT_EQ(texels[4 * i + 2], 255) << i;
  }
  for (std::size_t i = 8 * 4; i < 2 * 8 * 4; ++i) {
    ASSERT_EQ(texels[4 * i + 1], 255) << i;
    ASSERT_EQ(texels[4 * i + 2], 0) << i;
  }
}

// Without sharing, each instance and each part of a file would use as much graphics memory as the first.
TEST_F(TextureLayersTest, ObjectsOfTheSameImagesShareThem) {
  add_image(make_plain_png(8, 2, {0, 0, 255}));
  add_image("no image");
  SharedTextures shared;
  const auto make_of = [&](const MeshAppearance& of) { return shared.make(std::make_shared<const MeshAppearance>(of), notes); };
  const auto first = make_of(appearance);
  ASSERT_TRUE(first);
  appearance.triangles.resize(5);
  EXPECT_EQ(make_of(appearance), first);
  EXPECT_EQ(notes.size(), 1U) << "the image that cannot be read is named once";
  MeshAppearance other = appearance;
  other.images[0].bytes = make_plain_png(8, 2, {0, 255, 0});
  EXPECT_NE(make_of(other), first);
  appearance.materials[1].image.reset();
  const auto fewer = make_of(appearance);
  ASSERT_TRUE(fewer);
  EXPECT_NE(fewer, first);
  EXPECT_EQ(fewer->layer_of(), (std::vector<std::uint8_t>{1, 0}));
}

// A layer's number is a byte, and 0 means none.
TEST_F(TextureLayersTest, ThereAreAtMost255) {
  const std::string png = make_plain_png(1, 1, {255, 0, 0});
  for (int i = 0; i < 257; ++i) add_image(png);
  const auto layers = make();
  ASSERT_TRUE(layers);
  EXPECT_EQ(layers->layer_of()[253], 254);
  EXPECT_EQ(layers->layer_of()[254], 255);
  EXPECT_EQ(layers->layer_of()[255], 0);
  EXPECT_EQ(layers->layer_of()[256], 0);
  EXPECT_EQ(size_of(*layers)[2], 255);
}

TEST_F(TextureLayersTest, ASideHasAtMost4096Texels) {
  add_image(make_plain_png(5000, 1, {255, 0, 0}));
  const auto wide = make();
  ASSERT_TRUE(wide);
  EXPECT_EQ(size_of(*wide), (std::array<int, 3>{4096, 1, 1}));
  appearance = {};
  add_image(make_plain_png(1, 5000, {255, 0, 0}));
  const auto high = make();
  ASSERT_TRUE(high);
  EXPECT_EQ(size_of(*high), (std::array<int, 3>{1, 4096, 1}));
}

// Five layers of 4096 x 4096 would take 320 MiB; 256 are allowed.
TEST_F(TextureLayersTest, ManyLargeLayersAreHalved) {
  add_image(make_plain_png(4096, 1, {255, 0, 0}));
  add_image(make_plain_png(1, 4096, {0, 255, 0}));
  for (int i = 0; i < 3; ++i) add_image(make_plain_png(1, 1, {0, 0, 255}));
  const auto layers = make();
  ASSERT_TRUE(layers);
  EXPECT_EQ(size_of(*layers), (std::array<int, 3>{2048, 2048, 5}));
}

TEST_F(TextureLayersTest, TheUnitIsTheActiveOne) {
  glActiveTexture(GL_TEXTURE3);
  EXPECT_EQ(TextureLayers::unit(), 3);
  glActiveTexture(GL_TEXTURE0);
  EXPECT_EQ(TextureLayers::unit(), 0);
}

}  // namespace
}  // namespace hapton
