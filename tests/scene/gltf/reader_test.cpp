// How nodes, accessors and extensions of glTF change the triangles; tests/scene/raw_mesh_test.cpp tests the rest of the reader.
#include "scene/gltf/reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/scene/gltf/gltf_samples.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string floats(std::initializer_list<float> values) {
  std::string bytes;
  for (const float value : values) sample::append(bytes, value);
  return bytes;
}

std::string reader_error(const Result<RawMesh>& raw) { return raw ? "it was read" : raw.error().what; }

std::string instancing(const std::string& attributes) {
  return R"("extensionsUsed":["EXT_mesh_gpu_instancing"],"nodes":[{"mesh":0,"translation":[100,0,0],"extensions":)"
         R"({"EXT_mesh_gpu_instancing":{"attributes":{)" +
         attributes + R"(}}}}],"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}])";
}

struct InstancedMesh {
  sample::Pieces pieces;
  std::string accessors;
};

// The tetrahedron twice: once as it is; once ten metres up, turned by 180 degrees about z and three times as large.
InstancedMesh instanced_tetrahedron() {
  InstancedMesh two;
  const TriangleMesh mesh = sample::tetrahedron();
  two.pieces.add(sample::positions_of(mesh));
  two.pieces.add(sample::indices_of(mesh));
  two.pieces.add(floats({0, 0, 0, 0, 0, 10}));
  two.pieces.add(floats({0, 0, 0, 1, 0, 0, 1, 0}));
  two.pieces.add(floats({1, 1, 1, 3, 3, 3}));
  two.accessors =
      sample::accessors_of(mesh) +
      R"(,{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"},{"bufferView":3,"componentType":5126,"count":2,"type":"VEC4"})"
      R"(,{"bufferView":4,"componentType":5126,"count":2,"type":"VEC3"})";
  return two;
}

TEST(GltfInstancing, DrawsTheMeshOfANodeAtEveryInstance) {
  const auto [pieces, accessors] = instanced_tetrahedron();
  const auto raw = read_glb(pieces.glb(accessors, instancing(R"("TRANSLATION":2,"ROTATION":3,"SCALE":4)")), ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->notes, IsEmpty());
  const TriangleMesh mesh = sample::tetrahedron();
  ASSERT_EQ(raw->mesh.triangles.size(), 2 * mesh.triangles.size());
  EXPECT_EQ(raw->mesh.corner(0, 1), Vec3(101.5, 0, 0));
  EXPECT_LT((raw->mesh.corner(4, 1) - Vec3(100 - 4.5, 0, 10)).norm(), 1e-12);
  EXPECT_EQ(raw->parts.size(), 1U);
}

TEST(GltfInstancing, SaysWhatIsWrong) {
  auto [pieces, accessors] = instanced_tetrahedron();
  EXPECT_THAT(reader_error(read_glb(pieces.glb(accessors, instancing(R"("TRANSLATION":3)")), ".")), HasSubstr("not of type VEC3"));
  std::string with_fewer_scales = accessors;
  with_fewer_scales.replace(with_fewer_scales.rfind("\"count\":2"), 9, "\"count\":1");
  EXPECT_THAT(reader_error(read_glb(pieces.glb(with_fewer_scales, instancing(R"("TRANSLATION":2,"SCALE":4)")), ".")),
              HasSubstr("2 of one attribute and 1"));
}

TEST(GltfInstancing, CountsAllInstancesAgainstTheLimit) {
  const auto [pieces, accessors] = instanced_tetrahedron();
  const std::string glb = pieces.glb(accessors, instancing(R"("TRANSLATION":2)"));
  EXPECT_TRUE(read_glb(glb, ".", 8));
  EXPECT_THAT(reader_error(read_glb(glb, ".", 7)), HasSubstr("more than 7 triangles with all its instances"));
}

// Morph targets that have no data, or share the same data, take only a few bytes each in the file.
TEST(GltfMorphTargets, AreBoundedByTheLimitOfTriangles) {
  const auto glb_of = [](int targets, const std::string& nodes = R"([{"mesh":0}])", const std::string& roots = "[0]",
                         const std::string& more_primitives = "") {
    const TriangleMesh mesh = sample::tetrahedron();
    std::string json = sample::gltf_json(mesh, "", nodes, roots);
    std::string list = "{}";
    for (int t = 1; t < targets; ++t) list += R"(,{"POSITION":0})";
    const std::string indices = R"("indices":1)";
    json.replace(json.find(indices), indices.size() + 1, R"("targets":[)" + list + "]," + indices + "}" + more_primitives);
    return sample::glb(json, sample::gltf_buffer(mesh));
  };
  EXPECT_TRUE(read_glb(glb_of(6), ".", 8));
  EXPECT_THAT(reader_error(read_glb(glb_of(7), ".", 8)), HasSubstr("has 7 morph targets of 4 vertices, more than 24 displacements"));
  const std::string two = R"([{"mesh":0},{"mesh":0}])";
  EXPECT_TRUE(read_glb(glb_of(3, two, "[0,1]"), ".", 8));
  EXPECT_THAT(reader_error(read_glb(glb_of(4, two, "[0,1]"), ".", 8)), HasSubstr("more than 24 displacements of morph targets"));
  // A primitive with fewer morph targets counts as having as many as the one with the most.
  const std::string with_one = R"(,{"attributes":{"POSITION":0},"indices":1,"targets":[{}]})";
  EXPECT_TRUE(read_glb(glb_of(3, R"([{"mesh":0}])", "[0]", with_one), ".", 8));
  EXPECT_THAT(reader_error(read_glb(glb_of(4, R"([{"mesh":0}])", "[0]", with_one), ".", 8)),
              HasSubstr("more than 24 displacements of morph targets"));
}

// Nodes may share a mesh without triangles, with a long name or with a list of weights: the limit of triangles does not bound these.
TEST(GltfNodes, AreBoundedByWhatTheyReadWithoutTriangles) {
  const auto glb_of = [](int nodes, const std::string& count, const std::string& mesh_members) {
    const TriangleMesh mesh = sample::tetrahedron();
    std::string list = R"({"mesh":0})";
    std::string roots = "0";
    for (int n = 1; n < nodes; ++n) {
      list += R"(,{"mesh":0})";
      roots += fmt::format(",{}", n);
    }
    std::string json = sample::gltf_json(mesh, "", "[" + list + "]", "[" + roots + "]");
    json.replace(json.find(R"("count":12)"), 10, R"("count":)" + count);
    json.insert(json.find(R"("primitives")"), mesh_members);
    return sample::glb(json, sample::gltf_buffer(mesh));
  };
  const std::string what = "has more than 80 vertices, morph targets, instances, primitives and bytes of names with all its nodes";
  EXPECT_TRUE(read_glb(glb_of(13, "0", ""), ".", 8));
  EXPECT_THAT(reader_error(read_glb(glb_of(14, "0", ""), ".", 8)), HasSubstr(what));
  EXPECT_TRUE(read_glb(glb_of(2, "3", R"("name":")" + std::string(34, 'x') + R"(",)"), ".", 8));
  EXPECT_THAT(reader_error(read_glb(glb_of(2, "3", R"("name":")" + std::string(35, 'x') + R"(",)"), ".", 8)), HasSubstr(what));
  EXPECT_TRUE(read_glb(glb_of(2, "3", R"("weights":[0,0,0,0,0],)"), ".", 8));
  std::string weights = "0";
  for (int n = 1; n < 35; ++n) weights += ",0";
  EXPECT_THAT(reader_error(read_glb(glb_of(2, "3", R"("weights":[)" + weights + "],"), ".", 8)), HasSubstr(what));
}

// Normalized indices would be fractions: each would mean vertex 0 or 1.
TEST(GltfIndices, AreNotNormalized) {
  const TriangleMesh mesh = sample::tetrahedron();
  std::string json = sample::gltf_json(mesh, "");
  json.insert(json.find(R"("componentType":5123)"), R"("normalized":true,)");
  EXPECT_THAT(reader_error(read_glb(sample::glb(json, sample::gltf_buffer(mesh)), ".")), HasSubstr("accessors[1] are not whole numbers"));
}

// A sparse accessor replaces two of the four vertices of the base; without a base all other vertices are zero.
std::string sparse_glb(const std::string& base, const std::string& indices, const std::string& index_type = "5121") {
  const TriangleMesh mesh = sample::tetrahedron();
  sample::Pieces pieces;
  pieces.add(sample::positions_of(mesh));
  pieces.add(sample::indices_of(mesh));
  pieces.add(indices);
  pieces.add(floats({5, 6, 7, 8, 9, 10}));
  const std::string accessors = fmt::format(
      R"({{{}"componentType":5126,"count":4,"type":"VEC3","sparse":{{"count":2,"indices":{{"bufferView":2,"componentType":{}}},)"
      R"("values":{{"bufferView":3}}}}}},{{"bufferView":1,"componentType":5123,"count":12,"type":"SCALAR"}})",
      base, index_type);
  return pieces.glb(accessors, sample::kOneNode);
}

TEST(GltfSparse, ReplacesItems) {
  const std::string indices("\1\3", 2);
  const auto raw = read_glb(sparse_glb(R"("bufferView":0,)", indices), ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->mesh.vertices, ElementsAre(Vec3(0, 0, 0), Vec3(5, 6, 7), Vec3(0, 2.25, 0), Vec3(8, 9, 10)));
  const auto zeros = read_glb(sparse_glb("", indices), ".");
  ASSERT_TRUE(zeros) << zeros.error().what;
  EXPECT_THAT(zeros->mesh.vertices, ElementsAre(Vec3(0, 0, 0), Vec3(5, 6, 7), Vec3(0, 0, 0), Vec3(8, 9, 10)));
}

TEST(GltfSparse, SaysWhatIsWrong) {
  const std::string base = R"("bufferView":0,)";
  EXPECT_THAT(reader_error(read_glb(sparse_glb(base, std::string("\1\4", 2)), ".")), HasSubstr("index 1 is 4, out of range"));
  EXPECT_THAT(reader_error(read_glb(sparse_glb(base, std::string("\1", 1)), ".")),
              HasSubstr("promises 2 items but its buffer view holds 1"));
  EXPECT_THAT(reader_error(read_glb(sparse_glb(base, std::string(8, '\1'), "5126"), ".")), HasSubstr("5126, not an index"));
}

TEST(GltfSparse, DoesNotBelieveACountOfZeros) {
  std::string glb = sample::inline_gltf(sample::tetrahedron());
  glb.replace(glb.find(R"("bufferView":0,"componentType":5126,"count":4)"), 45, R"("componentType":5126,"count":4000000000)");
  EXPECT_THAT(reader_error(read_gltf(glb, ".")), HasSubstr("promises 4000000000 zeros"));
}

TEST(GltfExtensions, NotesWhatMayChangeTheShapeAndIsNotRead) {
  std::string text = sample::inline_gltf(sample::tetrahedron());
  text.insert(1, R"("extensionsUsed":["KHR_materials_unlit","NV_micromesh","KHR_texture_transform","NV_micromesh"],)");
  const auto raw = read_gltf(text, ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->notes, ElementsAre(AllOf(HasSubstr("'NV_micromesh'"), HasSubstr("not read"))));
}

TEST(GltfMaterials, NotesNormalMaps) {
  std::string text = sample::inline_gltf(sample::tetrahedron());
  text.insert(1, R"("materials":[{"normalTexture":{"index":0}},{"name":"plain"},{"normalTexture":{"index":0}}],)");
  const auto raw = read_gltf(text, ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->notes, ElementsAre(AllOf(HasSubstr("normal maps of 2 materials"), HasSubstr("normal_map = true"))));
}

TEST(GltfExtensions, SkipsInvisibleNodes) {
  const std::string hidden = R"("extensions":{"KHR_node_visibility":{"visible":false}})";
  const TriangleMesh mesh = sample::tetrahedron();
  const auto count = [&](const std::string& first) {
    const std::string nodes = "[{\"mesh\":0},{\"children\":[2]" + first + "},{\"mesh\":0}]";
    const auto raw = read_glb(sample::glb(sample::gltf_json(mesh, "", nodes, "[0,1]"), sample::gltf_buffer(mesh)), ".");
    return raw ? raw->mesh.triangles.size() + raw->notes.size() : 0;
  };
  EXPECT_EQ(count(""), 8U);
  EXPECT_EQ(count("," + hidden), 5U);  // four triangles and a note
}

}  // namespace
}  // namespace hapton
