// Normal maps that a scene file or a glTF file names, as reliefs that can be felt.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstring>
#include <numbers>
#include <string>
#include <utility>

#include "scene/map_reader.h"
#include "scene/scene_file.h"
#include "tests/scene/made_pictures.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// The normal of a wavy surface at (u, v) of an image of 100 mm. The largest slope is kLargestSlope along u, and half of it along v.
constexpr double kLargestSlope = 0.3;
Vec3 wave_normal(double u, double v) {
  const double full_turn = 2.0 * std::numbers::pi;
  return Vec3(-kLargestSlope * std::cos(full_turn * u), 0.5 * kLargestSlope * std::sin(2.0 * full_turn * v), 1.0)
      .normalized();  // green is up, v is down
}

// has_alpha: with an alpha channel; many tools store a height in it.
std::string wave_png(bool has_alpha = false) {
  std::vector<std::uint8_t> rows;
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const Vec3 normal = wave_normal((x + 0.5) / 64.0, (y + 0.5) / 64.0);
      for (int k = 0; k < 3; ++k) rows.push_back(static_cast<std::uint8_t>(std::lround(127.5 * (normal[k] + 1.0))));
      if (has_alpha) rows.push_back(static_cast<std::uint8_t>(4 * x));
    }
  }
  return picture::png_of(64, 64, rows, has_alpha ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB);
}

class NormalMap : public ::testing::Test {
 protected:
  NormalMap() {
    folder_.write("waves.png", wave_png());
    folder_.write("plain.png", picture::png_of(8, 8, picture::grey_rows(8, 8, [](int, int) { return 128; })));
    folder_.write("sheet.obj",
                  "v 0 0 0\nv 100 0 0\nv 100 100 0\nv 0 100 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n");
    folder_.write("bare.obj", "v 0 0 0\nv 100 0 0\nv 100 100 0\nf 1 2 3\n");
    folder_.write("sheet.bin", buffer());
  }

  // The buffer of the glTF file: a square of 100 mm with its texture coordinates.
  static std::string buffer() {
    const float numbers[] = {0, 0, 0, 0.1F, 0, 0, 0.1F, 0.1F, 0, 0, 0.1F, 0, 0, 1, 1, 1, 1, 0, 0, 0};
    const std::uint16_t indices[] = {0, 1, 2, 0, 2, 3};
    std::string bytes(sizeof(numbers) + sizeof(indices), '\0');
    std::memcpy(bytes.data(), numbers, sizeof(numbers));
    std::memcpy(bytes.data() + sizeof(numbers), indices, sizeof(indices));
    return bytes;
  }
  // A primitive with material 0 and, if second > 0, another one over the same square with material `second`.
  void write_gltf(const std::string& materials, int second = 0) {
    const auto primitive = [](int material) {
      return fmt::format(R"({{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},"indices":2,"material":{}}})", material);
    };
    folder_.write("sheet.gltf", R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[)" +
                                    primitive(0) + (second > 0 ? "," + primitive(second) : "") + R"(]}],"materials":[)" + materials +
                                    R"(],"textures":[{"source":0},{"source":1}],"images":[{"uri":"waves.png"},{"uri":"plain.png"}],
"buffers":[{"uri":"sheet.bin","byteLength":92}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},{"buffer":0,"byteOffset":80,"byteLength":12}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[0.1,0.1,0]},
{"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]})");
  }

  Result<Scene> load(const std::string& lines, const std::string& mesh) {
    const std::string unit = mesh.ends_with(".obj") ? "unit = 'mm'\n" : "";
    return load_scene(
        folder_.write("a.toml", "[[object]]\nmesh = '" + mesh + "'\n" + unit + "material = 'm'\n[material.m]\n" + lines + "\n"));
  }
  std::string error_of(const std::string& lines, const std::string& mesh = "sheet.obj") {
    const auto loaded = load(lines, mesh);
    return loaded ? "it was read" : loaded.error().what;
  }
  // The slopes of the relief that is felt are those of the map, along x (u) and along -y (v).
  void expect_waves(const std::string& lines, const std::string& mesh, double scale = 1.0) {
    const auto loaded = load(lines, mesh);
    ASSERT_TRUE(loaded) << loaded.error().what;
    const SurfaceMaps& maps = loaded->objects[0].effects.maps;
    ASSERT_TRUE(maps.height.is_on());
    EXPECT_EQ(maps.height.at_white, 0.0) << "the highest place is the surface";
    for (const double u : {0.1, 0.4, 0.75}) {
      for (const double v : {0.2, 0.55, 0.9}) {
        MapPlace place = map_gradients(maps.triangles->front());
        place.texcoord = {u, v};
        const Vec3 normal = wave_normal(u, v);
        const Vec3 expected = scale * Vec3(-normal.x() / normal.z(), -normal.y() / normal.z(), 0.0);
        EXPECT_LT((maps.sample(place).height_gradient - expected).norm(), 0.02 * scale) << u << ' ' << v;
      }
    }
  }

  ScratchFolder folder_;
};

TEST_F(NormalMap, IsFeltWithTheSlopesThatItHas) {
  expect_waves("normal_map = 'waves.png'", "sheet.obj");
  expect_waves("normal_map = 'waves.png'\nnormal_map_scale = 0.5", "sheet.obj", 0.5);
}

TEST_F(NormalMap, IsFeltAlikeWhateverItsAlphaIs) {
  folder_.write("alpha.png", wave_png(true));
  expect_waves("normal_map = 'alpha.png'", "sheet.obj");
}

TEST_F(NormalMap, OfAGltfFileIsFeltOnlyOnRequest) {
  write_gltf(R"({"normalTexture":{"index":0}})");
  expect_waves("normal_map = true", "sheet.gltf");
  write_gltf(R"({"normalTexture":{"index":0,"scale":2},"pbrMetallicRoughness":{"baseColorTexture":{"index":1}}})");
  expect_waves("normal_map = true\nnormal_map_scale = 0.25", "sheet.gltf", 0.5);
  const auto without_request = load("stiffness_n_per_m = 500", "sheet.gltf");
  ASSERT_TRUE(without_request) << without_request.error().what;
  EXPECT_FALSE(without_request->objects[0].effects.any());
}

// Only normal_map = true uses the normal map of the mesh file; materials with another image keep the file's texture coordinates.
TEST_F(NormalMap, LeavesTheTextureCoordinatesOfOtherImages) {
  const std::string moved = R"({"normalTexture":{"index":0,"extensions":{"KHR_texture_transform":{"scale":[7,7]}}}})";
  write_gltf(moved);
  expect_waves("normal_map = 'waves.png'", "sheet.gltf");
  const auto loaded = load("friction_map = 'plain.png'\nfriction_map_range = [0, 1]", "sheet.gltf");
  ASSERT_TRUE(loaded) << loaded.error().what;
  for (const std::string& note : loaded->notes) EXPECT_THAT(note, testing::Not(HasSubstr("texture coordinates")));
  EXPECT_EQ(loaded->objects[0].effects.maps.triangles->front().texcoord[1], Eigen::Vector2d(1, 1));
  EXPECT_THAT(error_of("normal_map = true", "sheet.gltf"), HasSubstr("no normal map, or not everywhere: name an image"));
}

TEST_F(NormalMap, TooSteepAReliefIsSmoothedAndSaysHowToKeepIt) {
  const auto loaded = load("normal_map = 'waves.png'\nnormal_map_scale = 10", "sheet.obj");
  ASSERT_TRUE(loaded) << loaded.error().what;
  const SurfaceMaps& maps = loaded->objects[0].effects.maps;
  EXPECT_LE(maps.height.steepest(*maps.triangles), SurfaceMaps::kSteepest);
  EXPECT_THAT(loaded->notes.back(), AllOf(HasSubstr("waves.png"), HasSubstr("a lower normal_map_scale keeps them")));
}

// Without this limit, the height is infinite in single precision, and so is the force.
TEST_F(NormalMap, AReliefHigherThanBumpsMayBeIsRejected) {
  for (const char* scale : {"1e4", "3e38"}) {
    write_gltf(fmt::format(R"({{"normalTexture":{{"index":0,"scale":{}}}}})", scale));
    EXPECT_THAT(
        error_of("normal_map = true", "sheet.gltf"),
        AllOf(HasSubstr("line "), HasSubstr("m high, and 10 m are the most: lower 'normal_map_scale', or the scale of normalTexture")));
  }
}

// A relief of 2,048 x 2,048 texels takes 16 MB: without sharing, hundreds of objects would use up all memory.
TEST_F(NormalMap, ObjectsThatFeelItAlikeShareTheRelief) {
  write_gltf(R"({"normalTexture":{"index":0}})");
  const std::string instances =
      "[[instance]]\nname = 'moved'\nof = 'sheet'\nposition_m = [0.7, -0.3, 0.2]\nrotation_deg = [20, 30, 40]\n"
      "[[instance]]\nname = 'large'\nof = 'sheet'\nscale = 2\n";
  for (const auto& [lines, mesh] : {std::pair{"normal_map = true\n", "sheet.gltf"},
                                    {"normal_map = 'waves.png'\n", "sheet.obj"},
                                    {"normal_map = 'waves.png'\nnormal_map_scale = 10\n", "sheet.obj"}}) {
    const auto loaded = load(lines + instances, mesh);
    ASSERT_TRUE(loaded) << loaded.error().what;
    ASSERT_EQ(loaded->objects.size(), 3U);
    const auto height = [&](std::size_t object) { return loaded->objects[object].effects.maps.height; };
    EXPECT_EQ(height(1).image, height(0).image) << lines;
    EXPECT_EQ(height(1).at_black, height(0).at_black);
    EXPECT_NEAR(height(2).at_black, 2.0 * height(0).at_black, 1e-6 * std::abs(height(0).at_black)) << "waves of twice the length";
  }
}

TEST_F(NormalMap, SaysWhatIsWrongAndWhere) {
  EXPECT_THAT(error_of("normal_map = 'plain.png'"), AllOf(HasSubstr("line 6: 'normal_map'"), HasSubstr("plain.png: is not a normal map")));
  EXPECT_THAT(error_of("normal_map = 'none.png'"), AllOf(HasSubstr("line 6"), HasSubstr("none.png")));
  EXPECT_THAT(error_of("normal_map = 3"), HasSubstr("'normal_map'"));
  EXPECT_THAT(error_of("normal_map = false"), HasSubstr("leave it out, or give true or an image"));
  EXPECT_THAT(error_of("normal_map = 'waves.png'\nbump_map = 'waves.png'\nbump_height_m = 0.001"), HasSubstr("keep one"));
  EXPECT_THAT(error_of("normal_map = 'waves.png'\nbump_height_m = 0.001"), HasSubstr("use 'normal_map_scale'"));
  EXPECT_THAT(error_of("normal_map = 'waves.png'\nbump_length_m = 0.001"), HasSubstr("leave out 'normal_map'"));
  EXPECT_THAT(error_of("normal_map = 'waves.png'\ndamping_ns_per_m = 1"), HasSubstr("source of energy"));
  EXPECT_THAT(error_of("normal_map = 'waves.png'\nnormal_map_scale = 0"), HasSubstr("above 0"));
  EXPECT_THAT(error_of("normal_map_scale = 1"), HasSubstr("no effect without 'normal_map'"));
  EXPECT_THAT(error_of("normal_map = 'waves.png'", "bare.obj"), HasSubstr("'normal_map' needs texture coordinates"));
  EXPECT_THAT(error_of("normal_map = true"), HasSubstr("has no normal map"));
}

TEST_F(NormalMap, OfSeveralMaterialsOneMustBeForAll) {
  write_gltf(R"({"normalTexture":{"index":0}},{"name":"smooth"})", 1);
  EXPECT_THAT(error_of("normal_map = true", "sheet.gltf"), HasSubstr("no normal map, or not everywhere"));
  write_gltf(R"({"normalTexture":{"index":0}},{"normalTexture":{"index":1}})", 1);
  EXPECT_THAT(error_of("normal_map = true", "sheet.gltf"), HasSubstr("several normal maps"));
  write_gltf(R"({"normalTexture":{"index":0}},{"normalTexture":{"index":0}})", 1);
  expect_waves("normal_map = true", "sheet.gltf");
  write_gltf(R"({"normalTexture":{"index":0,"texCoord":1},"pbrMetallicRoughness":{"baseColorTexture":{"index":1}}})");
  const auto moved = load("normal_map = true", "sheet.gltf");
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().what, HasSubstr("no normal map"));
}

}  // namespace
}  // namespace hapton
