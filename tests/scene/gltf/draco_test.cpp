#include "scene/gltf/draco.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/mesh_topology.h"
#include "scene/raw_mesh.h"
#include "tests/scene/gltf/draco_samples.h"
#include "tests/scene/gltf/gltf_samples.h"
#include "tests/scene/made_pictures.h"

#ifdef HAPTON_DRACO

namespace hapton {
namespace {

using sample::DracoKind;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(Draco, GivesTheMeshThatWasPacked) {
  const TriangleMesh mesh = make_icosphere(1.0, 3);
  for (const DracoKind kind : {DracoKind::edgebreaker, DracoKind::sequential}) {
    const auto raw = read_glb(sample::draco_glb(mesh, sample::draco(mesh, kind)), ".");
    ASSERT_TRUE(raw) << raw.error().what;
    EXPECT_THAT(raw->notes, IsEmpty());
    ASSERT_EQ(raw->mesh.triangles.size(), mesh.triangles.size());
    const MeshTopology topology = compute_mesh_topology(raw->mesh);
    EXPECT_TRUE(topology.is_closed());
    EXPECT_NEAR(topology.signed_volume, compute_mesh_topology(mesh).signed_volume, 1e-6);
  }
}

TEST(Draco, KeepsNormals) {
  const TriangleMesh mesh = make_icosphere(1.0, 2);
  std::vector<Eigen::Vector3f> normals;
  for (const Vec3& v : mesh.vertices) normals.push_back(v.normalized().cast<float>());
  const auto raw = read_glb(sample::draco_glb(mesh, sample::draco(mesh, DracoKind::edgebreaker, normals), true), ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->notes, IsEmpty());
  ASSERT_TRUE(raw->mesh.has_authored_normals());
  for (std::size_t t = 0; t < raw->mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 outward = raw->mesh.corner(t, k).normalized();
      EXPECT_GT(raw->mesh.authored_normals[t][static_cast<std::size_t>(k)].cast<double>().dot(outward), 0.999);
    }
  }
}

// Draco reorders the vertices, so each corner is compared with the values expected at its position.
TEST(Draco, KeepsTextureCoordinatesAndColours) {
  const TriangleMesh mesh = make_icosphere(1.0, 2);
  const std::string image = picture::png_of(4, 4, picture::grey_rows(4, 4, [](int, int) { return 51; }));
  for (const DracoKind kind : {DracoKind::edgebreaker, DracoKind::sequential}) {
    const auto raw = read_glb(sample::draco_appearance_glb(mesh, sample::draco_with_appearance(mesh, kind), image), ".", kMaxMeshTriangles,
                              AppearanceReading::on);
    ASSERT_TRUE(raw) << raw.error().what;
    EXPECT_THAT(raw->notes, IsEmpty());
    ASSERT_EQ(raw->appearance.triangles.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      const TriangleAppearance& appearance = raw->appearance.triangles[t];
      EXPECT_EQ(appearance.material, 0U);
      ASSERT_TRUE(appearance.has_colours);
      for (int k = 0; k < 3; ++k) {
        const Vec3 p = raw->mesh.corner(t, k);
        const CornerAppearance& corner = appearance.corners[static_cast<std::size_t>(k)];
        EXPECT_LT((corner.texcoord - sample::draco_texcoord(p)).norm(), 1e-6F);
        const auto [red, green, blue, alpha] = sample::draco_colour(p);
        EXPECT_EQ(corner.colour, (std::array{red, green, blue}));
        EXPECT_EQ(corner.alpha, alpha);
      }
    }
  }
}

TEST(Draco, HapticTexturesLieWhereItsCoordinatesSay) {
  const TriangleMesh mesh = make_icosphere(1.0, 2);
  const std::string image = picture::png_of(4, 4, picture::grey_rows(4, 4, [](int, int) { return 51; }));
  const std::string packed = sample::draco_with_appearance(mesh, DracoKind::edgebreaker);
  const auto raw =
      read_glb(sample::draco_appearance_glb(mesh, packed, image, R"("extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":0}},)",
                                            R"("extensions":{"MPEG_haptic_material":{"materials":[{"stiffness":[{"texture":{"index":0}}],)"
                                            R"("extras":{"hapton":{"stiffness_map_n_per_m":[100,200]}}}]}},)"),
               ".");
  ASSERT_TRUE(raw) << raw.error().what;
  ASSERT_EQ(raw->haptics.maps.triangles.size(), mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const CornerAppearance& corner = raw->haptics.maps.triangles[t].corners[static_cast<std::size_t>(k)];
      EXPECT_LT((corner.texcoord - sample::draco_texcoord(raw->mesh.corner(t, k))).norm(), 1e-6F);
    }
  }
}

// KHR_mesh_quantization permits such positions. The least normalized value of a signed type means -1, as in a file without Draco.
TEST(Draco, PositionsMayBeIntegersOfAnyType) {
  struct Type {
    std::size_t component_type;
    std::int32_t least, most;
  };
  for (const auto& [component_type, least, most] :
       {Type{5120, -128, 127}, Type{5121, 0, 255}, Type{5122, -32768, 32767}, Type{5123, 0, 65535}}) {
    for (const bool is_normalized : {false, true}) {
      SCOPED_TRACE(testing::Message() << component_type << " " << is_normalized);
      const std::vector<std::array<std::int32_t, 3>> corners = {{least, 0, 1}, {most, least, 0}, {1, most, most}};
      const auto mesh = gltf::decode_draco(sample::draco_of_integers(corners, component_type, is_normalized),
                                           {.position = 0, .normal = {}, .max_triangles = 10}, "here");
      ASSERT_TRUE(mesh) << mesh.error().what;
      ASSERT_EQ(mesh->corners.size(), 3U);
      const float unit = is_normalized ? 1.0F / static_cast<float>(most) : 1.0F;
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < 3; ++k) {
          const float whole = static_cast<float>(corners[c][k]);
          const float expected = is_normalized && corners[c][k] < -most ? -1.0F : whole * unit;
          EXPECT_NEAR(mesh->positions[mesh->corners[c]][static_cast<Eigen::Index>(k)], expected, 1e-7F * std::fabs(whole)) << c << " " << k;
        }
      }
    }
  }
}

// The most regular mesh with the best compression has the most triangles per byte: kMaxTrianglesOfAByte (draco.cpp) must admit it.
TEST(Draco, DecodesTheMostRegularMesh) {
  const TriangleMesh mesh = make_plane_grid(1.0, 500);
  const std::string packed = sample::draco(mesh, DracoKind::edgebreaker, {}, 11, 0);
  RecordProperty("triangles_a_byte", static_cast<int>(mesh.triangles.size() / packed.size()));
  EXPECT_LT(mesh.triangles.size() / packed.size(), 128U);
  const auto decoded = gltf::decode_draco(packed, {.position = 0, .normal = {}, .max_triangles = kMaxMeshTriangles}, "here");
  ASSERT_TRUE(decoded) << decoded.error().what;
  EXPECT_EQ(decoded->corners.size(), 3 * mesh.triangles.size());
}

TEST(Draco, RejectsWhatItsBytesCannotHold) {
  const TriangleMesh mesh = make_icosphere(1.0, 1);
  for (const DracoKind kind : {DracoKind::edgebreaker, DracoKind::sequential}) {
    const std::string packed = sample::draco(mesh, kind);
    // The two counts follow the header (edgebreaker: and the traversal type). Both become 0x0FFFFFFF, in four bytes of seven bits each.
    std::string hostile = packed.substr(0, kind == DracoKind::edgebreaker ? 12 : 11);
    for (int k = 0; k < 2; ++k) hostile += "\xFF\xFF\xFF\x7F";
    hostile += packed.substr(hostile.size());
    const auto rejected = gltf::decode_draco(hostile, {.position = 0, .normal = {}, .max_triangles = kMaxMeshTriangles}, "here");
    ASSERT_FALSE(rejected);
    EXPECT_THAT(rejected.error().what, HasSubstr("promise more triangles"));
  }
}

TEST(Draco, RejectsMoreThanExpected) {
  const TriangleMesh mesh = make_icosphere(1.0, 3);
  const auto rejected =
      gltf::decode_draco(sample::draco(mesh, DracoKind::edgebreaker), {.position = 0, .normal = {}, .max_triangles = 100}, "here");
  ASSERT_FALSE(rejected);
  EXPECT_THAT(rejected.error().what, HasSubstr("more triangles"));
}

TEST(Draco, SaysWhatIsWrong) {
  const TriangleMesh mesh = make_icosphere(1.0, 1);
  const std::string packed = sample::draco(mesh, DracoKind::edgebreaker);
  const auto error_of = [](const std::string& bytes, std::uint32_t position = 0) {
    const auto decoded = gltf::decode_draco(bytes, {.position = position, .normal = {}, .max_triangles = 1000}, "here");
    return decoded ? "it was read" : decoded.error().what;
  };
  EXPECT_THAT(error_of(""), HasSubstr("holds no Draco data"));
  EXPECT_THAT(error_of("nonsense that is long enough to be a header"), HasSubstr("holds no Draco data"));
  EXPECT_THAT(error_of(packed.substr(0, packed.size() / 2)), HasSubstr("broken"));
  EXPECT_THAT(error_of(packed, 7), HasSubstr("no positions of id 7"));
}

// Reads a GLB file after the last `from` in its JSON was replaced by `to`.
Result<RawMesh> read_changed(const std::string& glb, const std::string& from, const std::string& to) {
  std::uint32_t json_bytes = 0;
  std::memcpy(&json_bytes, glb.data() + 12, sizeof json_bytes);
  std::string json = glb.substr(20, json_bytes);
  EXPECT_NE(json.rfind(from), std::string::npos) << from;
  json.replace(json.rfind(from), from.size(), to);
  return read_glb(sample::glb(json, glb.substr(20 + json_bytes + 8)), ".");
}

// Truncated to 32 bits, 2^32 would be 0, the id of the positions.
TEST(Draco, AnIdBeyond32BitsIsRejected) {
  const TriangleMesh mesh = make_icosphere(1.0, 1);
  const std::string glb = sample::draco_glb(mesh, sample::draco(mesh, DracoKind::edgebreaker));
  const auto raw = read_changed(glb, R"("POSITION":0)", R"("POSITION":4294967296)");
  ASSERT_FALSE(raw);
  EXPECT_THAT(raw.error().what, HasSubstr("attributes.POSITION is 4294967296, beyond 32 bits"));
}

TEST(Draco, AnotherNumberOfCornersThanTheFilePromisesIsAnError) {
  const TriangleMesh mesh = make_icosphere(1.0, 1);
  const std::string glb = sample::draco_glb(mesh, sample::draco(mesh, DracoKind::edgebreaker));
  const auto raw = read_changed(glb, "\"count\":240,", "\"count\":237,");
  ASSERT_FALSE(raw);
  EXPECT_THAT(raw.error().what, HasSubstr("holds 240 corners where the file promises 237"));
}

// A haptic texture needs texture coordinates: it is an error if the attribute is missing or has colours.
TEST(Draco, HapticTexturesNeedCoordinatesOfTwoNumbers) {
  const TriangleMesh mesh = make_icosphere(1.0, 1);
  const std::string image = picture::png_of(4, 4, picture::grey_rows(4, 4, [](int, int) { return 51; }));
  const std::string glb =
      sample::draco_appearance_glb(mesh, sample::draco_with_appearance(mesh, DracoKind::edgebreaker), image,
                                   R"("extensions":{"MPEG_haptic_material":{"hapticMaterialIndex":0}},)",
                                   R"("extensions":{"MPEG_haptic_material":{"materials":[{"stiffness":[{"texture":{"index":0}}],)"
                                   R"("extras":{"hapton":{"stiffness_map_n_per_m":[100,200]}}}]}},)");
  EXPECT_TRUE(read_changed(glb, R"("TEXCOORD_0":1)", R"("TEXCOORD_0":1)"));
  const auto from_colours = read_changed(glb, R"("TEXCOORD_0":1)", R"("TEXCOORD_0":2)");
  ASSERT_FALSE(from_colours);
  EXPECT_THAT(from_colours.error().what, HasSubstr(".TEXCOORD_0 is not of type VEC2"));
  const auto from_no_attribute = read_changed(glb, R"("TEXCOORD_0":1)", R"("TEXCOORD_0":7)");
  ASSERT_FALSE(from_no_attribute);
  EXPECT_THAT(from_no_attribute.error().what, HasSubstr("no TEXCOORD_0"));
}

// Bytes changed at random: never a crash, a hang or an unsound mesh.
TEST(Draco, SurvivesDamage) {
  const unsigned seed = 20261121;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  const TriangleMesh mesh = make_icosphere(1.0, 2);
  const std::string image = picture::png_of(4, 4, picture::grey_rows(4, 4, [](int, int) { return 51; }));
  for (const DracoKind kind : {DracoKind::edgebreaker, DracoKind::sequential}) {
    const std::string without_appearance = sample::draco(mesh, kind, {}, 11);
    const std::string with_appearance = sample::draco_with_appearance(mesh, kind);
    for (int round = 0; round < 4000; ++round) {
      const bool has_appearance = round % 4 == 0;
      std::string damaged = has_appearance ? with_appearance : without_appearance;
      for (unsigned k = 0; k <= random() % 3; ++k) damaged[random() % damaged.size()] = static_cast<char>(random());
      const auto raw = has_appearance
                           ? read_glb(sample::draco_appearance_glb(mesh, damaged, image), ".", kMaxMeshTriangles, AppearanceReading::on)
                           : read_glb(sample::draco_glb(mesh, damaged), ".");
      if (!raw) continue;
      for (const Vec3& v : raw->mesh.vertices) ASSERT_TRUE(v.allFinite());
      for (const Triangle& t : raw->mesh.triangles) ASSERT_LT(*std::max_element(t.begin(), t.end()), raw->mesh.vertices.size());
    }
  }
}

}  // namespace
}  // namespace hapton

#endif
