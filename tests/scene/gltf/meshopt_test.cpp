#include "scene/gltf/meshopt.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "scene/gltf/buffers.h"
#include "scene/raw_mesh.h"
#include "tests/scene/gltf/gltf_samples.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kMeshoptExtensions =
    R"("extensionsUsed":["EXT_meshopt_compression"],"extensionsRequired":["EXT_meshopt_compression"],)";

// The positions have the mode ATTRIBUTES, the indices TRIANGLES or, as a sequence, INDICES.
std::string compressed_glb(const TriangleMesh& mesh, bool as_sequence) {
  sample::Pieces pieces;
  const std::size_t n = mesh.vertices.size();
  pieces.add_meshopt(sample::meshopt_vertices(sample::positions_of(mesh), n, 12), n, 12, "ATTRIBUTES");
  pieces.add_meshopt(as_sequence ? sample::meshopt_indices(mesh) : sample::meshopt_triangles(mesh), 3 * mesh.triangles.size(), 2,
                     as_sequence ? "INDICES" : "TRIANGLES");
  return pieces.glb(sample::accessors_of(mesh), std::string(kMeshoptExtensions) + sample::kOneNode);
}

TEST(Meshopt, GivesTheMeshThatWasPacked) {
  const TriangleMesh mesh = make_icosphere(1.0, 3);
  for (const bool as_sequence : {false, true}) {
    const auto raw = read_glb(compressed_glb(mesh, as_sequence), ".");
    ASSERT_TRUE(raw) << raw.error().what;
    EXPECT_THAT(raw->notes, IsEmpty());
    ASSERT_EQ(raw->mesh.triangles.size(), mesh.triangles.size());
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
      // The codec may begin a triangle at another of its corners.
      Vec3 sum = Vec3::Zero();
      Vec3 expected = Vec3::Zero();
      for (int k = 0; k < 3; ++k) {
        sum += raw->mesh.corner(t, k);
        expected += mesh.corner(t, k).cast<float>().cast<double>();
      }
      EXPECT_LT((sum - expected).norm(), 1e-12);
    }
  }
}

TEST(Meshopt, UndoesFilters) {
  const TriangleMesh mesh = make_icosphere(1.0, 2);
  const std::size_t n = mesh.vertices.size();
  std::vector<float> positions;
  std::vector<float> normals;
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(v[axis]));
    for (int axis = 0; axis < 3; ++axis) normals.push_back(static_cast<float>(v.normalized()[axis]));
    normals.push_back(0.0F);
  }
  std::string exponential(12 * n, '\0');
  meshopt_encodeFilterExp(exponential.data(), n, 12, 20, positions.data());
  std::string octahedral(8 * n, '\0');
  meshopt_encodeFilterOct(octahedral.data(), n, 8, 12, normals.data());
  sample::Pieces pieces;
  pieces.add_meshopt(sample::meshopt_vertices(exponential, n, 12), n, 12, "ATTRIBUTES", R"(,"filter":"EXPONENTIAL")");
  pieces.add_meshopt(sample::meshopt_triangles(mesh), 3 * mesh.triangles.size(), 2, "TRIANGLES");
  pieces.add_meshopt(sample::meshopt_vertices(octahedral, n, 8), n, 8, "ATTRIBUTES", R"(,"filter":"OCTAHEDRAL")");
  const std::string accessors =
      sample::accessors_of(mesh) + fmt::format(R"(,{{"bufferView":2,"componentType":5122,"normalized":true,"count":{},"type":"VEC3"}})", n);
  const auto raw = read_glb(
      pieces.glb(accessors, R"("nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":2},"indices":1}]}])"),
      ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->notes, IsEmpty());
  ASSERT_TRUE(raw->mesh.has_authored_normals());
  for (std::size_t t = 0; t < raw->mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(raw->mesh.corner(t, k).norm(), 1.0, 1e-4);
      const Vec3 outward = raw->mesh.corner(t, k).normalized();
      EXPECT_GT(raw->mesh.authored_normals[t][static_cast<std::size_t>(k)].cast<double>().dot(outward), 0.999);
    }
  }
}

// Instances of a mesh (EXT_mesh_gpu_instancing) can have rotations that are stored in this way. A quaternion and its negative are the same
// rotation.
TEST(Meshopt, UndoesTheFilterOfRotations) {
  std::vector<Eigen::Vector4f> rotations;
  for (int n = 0; n < 8; ++n) rotations.push_back(Eigen::Vector4f(1.0F, 0.3F * static_cast<float>(n), -0.5F, 0.2F).normalized());
  std::string filtered(8 * rotations.size(), '\0');
  meshopt_encodeFilterQuat(filtered.data(), rotations.size(), 8, 16, rotations.front().data());
  const auto layout =
      gltf::meshopt_layout_of({{"mode", "ATTRIBUTES"}, {"filter", "QUATERNION"}, {"count", rotations.size()}, {"byteStride", 8}}, "here");
  ASSERT_TRUE(layout) << layout.error().what;
  const auto items = gltf::decode_meshopt(sample::meshopt_vertices(filtered, rotations.size(), 8), *layout, "here");
  ASSERT_TRUE(items) << items.error().what;
  ASSERT_EQ(items->size(), 8 * rotations.size());
  for (std::size_t n = 0; n < rotations.size(); ++n) {
    std::array<std::int16_t, 4> found = {};
    std::memcpy(found.data(), items->data() + 8 * n, sizeof found);
    const Eigen::Vector4f read = Eigen::Vector4f(found[0], found[1], found[2], found[3]) / 32767.0F;
    EXPECT_NEAR(std::fabs(read.dot(rotations[n])), 1.0F, 1e-4F) << n;
    EXPECT_NEAR(read.norm(), 1.0F, 1e-4F) << n;
  }
}

TEST(Meshopt, DoesNotBelieveCounts) {
  for (const auto& [mode, stride] : {std::pair("ATTRIBUTES", 12), {"TRIANGLES", 4}, {"INDICES", 4}}) {
    const auto layout = gltf::meshopt_layout_of({{"mode", mode}, {"count", 3000000000U}, {"byteStride", stride}}, "here");
    ASSERT_TRUE(layout) << layout.error().what;
    const auto rejected = gltf::decode_meshopt("\xA0 some bytes", *layout, "here");
    ASSERT_FALSE(rejected);
    EXPECT_THAT(rejected.error().what, AllOf(HasSubstr("promises 3000000000 items"), HasSubstr("cut short")));
  }
}

// Equal items take the fewest bytes: the bound on the number of items must admit them.
TEST(Meshopt, TakesItemsThatAreAllEqual) {
  constexpr std::size_t kItems = 100000;
  const std::string packed = sample::meshopt_vertices(std::string(12 * kItems, '\0'), kItems, 12);
  const auto layout = gltf::meshopt_layout_of({{"mode", "ATTRIBUTES"}, {"count", kItems}, {"byteStride", 12}}, "here");
  const auto items = gltf::decode_meshopt(packed, *layout, "here");
  ASSERT_TRUE(items) << items.error().what;
  EXPECT_EQ(items->size(), 12 * kItems);
}

// Each view is decompressed into memory of its own, so there is a bound on their sum.
TEST(Meshopt, ViewsOfTheSameBytesAreBoundedTogether) {
  constexpr std::size_t kItems = 100000;
  const std::string packed = sample::meshopt_vertices(std::string(12 * kItems, '\0'), kItems, 12);
  const gltf::Json compression = {
      {"buffer", 0}, {"byteLength", packed.size()}, {"mode", "ATTRIBUTES"}, {"count", kItems}, {"byteStride", 12}};
  const gltf::Json view = {{"buffer", 0}, {"byteLength", 0}, {"extensions", {{"EXT_meshopt_compression", compression}}}};
  gltf::Json root = {{"buffers", gltf::Json::array({{{"byteLength", packed.size()}}})}, {"bufferViews", gltf::Json::array()}};
  for (int v = 0; v < 64; ++v) root["bufferViews"].push_back(view);
  gltf::Buffers buffers(root, packed, ".");
  EXPECT_TRUE(buffers.view(0, "here"));
  EXPECT_TRUE(buffers.view(0, "here")) << "it is decompressed once";
  std::string error;
  for (int v = 1; v < 64 && error.empty(); ++v) {
    if (const auto read = buffers.view(v, "here"); !read) error = read.error().what;
  }
  EXPECT_THAT(error, HasSubstr("its compressed views unfold to more than"));
}

TEST(Meshopt, SaysWhatIsWrong) {
  const auto error_of = [](const gltf::Json& json) {
    const auto layout = gltf::meshopt_layout_of(json, "here");
    return layout ? "it was accepted" : layout.error().what;
  };
  EXPECT_THAT(error_of({{"mode", "ZIP"}, {"count", 1}, {"byteStride", 4}}), HasSubstr("mode is 'ZIP'"));
  EXPECT_THAT(error_of({{"mode", "INDICES"}, {"count", 1}, {"byteStride", 3}}), HasSubstr("byteStride is 3"));
  EXPECT_THAT(error_of({{"mode", "ATTRIBUTES"}, {"count", 1}, {"byteStride", 6}}), HasSubstr("byteStride is 6"));
  EXPECT_THAT(error_of({{"mode", "ATTRIBUTES"}, {"count", 1}, {"byteStride", 260}}), HasSubstr("byteStride is 260"));
  EXPECT_THAT(error_of({{"mode", "ATTRIBUTES"}, {"filter", "QUATERNION"}, {"count", 1}, {"byteStride", 4}}), HasSubstr("byteStride is 4"));
  EXPECT_THAT(error_of({{"mode", "TRIANGLES"}, {"filter", "OCTAHEDRAL"}, {"count", 3}, {"byteStride", 4}}), HasSubstr("only attributes"));
  EXPECT_THAT(error_of({{"mode", "TRIANGLES"}, {"count", 4}, {"byteStride", 4}}), HasSubstr("multiple of 3"));
  EXPECT_THAT(error_of({{"mode", "TRIANGLES"}, {"byteStride", 4}}), HasSubstr("count is missing"));
  const auto layout = gltf::meshopt_layout_of({{"mode", "TRIANGLES"}, {"count", 3}, {"byteStride", 4}}, "here");
  const auto broken = gltf::decode_meshopt("nonsense, and long enough", *layout, "here");
  ASSERT_FALSE(broken);
  EXPECT_THAT(broken.error().what, HasSubstr("broken"));
}

// Bytes changed at random: never a crash or an unsound mesh.
TEST(Meshopt, SurvivesDamage) {
  const unsigned seed = 20261121;
  RecordProperty("seed", static_cast<int>(seed));
  std::mt19937 random(seed);
  const std::string undamaged = compressed_glb(make_icosphere(1.0, 1), false);
  for (int round = 0; round < 5000; ++round) {
    std::string damaged = undamaged;
    for (unsigned k = 0; k <= random() % 3; ++k) damaged[20 + random() % (damaged.size() - 20)] = static_cast<char>(random());
    const auto raw = read_glb(damaged, ".");
    if (!raw) continue;
    for (const Vec3& v : raw->mesh.vertices) ASSERT_TRUE(v.allFinite());
    for (const Triangle& t : raw->mesh.triangles) ASSERT_LT(*std::max_element(t.begin(), t.end()), raw->mesh.vertices.size());
  }
}

}  // namespace
}  // namespace hapton
