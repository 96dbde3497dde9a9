// What each reader makes of good and bad files of its format.
#include "scene/raw_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "scene/polygon.h"
#include "scene/read_mtl.h"
#include "tests/scene/sample_files.h"

namespace hapton {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const std::string kThreeVertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

std::string read_error_of(const Result<RawMesh>& read) { return read ? "it was read" : read.error().what; }

std::vector<std::string> part_names(const RawMesh& raw) {
  std::vector<std::string> names;
  for (const MeshPart& part : raw.parts) names.push_back(part.name);
  return names;
}

TEST(ReadObj, TakesAllWaysToWriteAFace) {
  const auto raw = read_obj(kThreeVertices +
                            "v 1 1 0\nvt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2/1 3/1\nf 1/1/1 2/1/1 3/1/1\nf 1//1 2//1 3//1\n"
                            "f -4 -3 -2 # a comment\nf 1 2 \\\n 3\r\n\tf +1 2 4 3\n");
  ASSERT_TRUE(raw) << raw.error().what;
  ASSERT_THAT(raw->mesh.triangles, SizeIs(8));
  for (int t = 0; t < 6; ++t) EXPECT_EQ(raw->mesh.triangles[t], (Triangle{0, 1, 2})) << t;
}

TEST(ReadObj, KeepsDoubles) {
  const auto raw = read_obj("v 1000000.0625 1e-320 0.1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_EQ(raw->mesh.vertices[0].x(), 1000000.0625);
  EXPECT_EQ(raw->mesh.vertices[0].z(), 0.1);
}

TEST(ReadObj, NamesParts) {
  const auto raw = read_obj(kThreeVertices + "o one\nf 1 2 3\ng empty\ng two words\nf 1 2 3\nf 3 2 1\n");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(part_names(*raw), ElementsAre("one", "two words"));
  EXPECT_EQ(raw->parts[1].first_triangle, 1U);
  EXPECT_EQ(raw->parts[1].triangle_count, 2U);
}

TEST(ReadObj, KeepsTheObjectOfAGroup) {
  const auto raw = read_obj(kThreeVertices + "o body\nf 1 2 3\ng left\nf 1 2 3\no wheel\ng left\nf 1 2 3\n");
  ASSERT_TRUE(raw) << raw.error().what;
  ASSERT_EQ(raw->parts.size(), 3U);
  EXPECT_EQ(full_name(raw->parts[0]), "body");
  EXPECT_EQ(full_name(raw->parts[1]), "body/left");
  EXPECT_EQ(full_name(raw->parts[2]), "wheel/left");
  MeshFile file;
  file.mesh = raw->mesh;
  file.parts = raw->parts;
  const auto count_of = [&](const char* name) {
    const auto part = extract_part(file, name);
    return part ? part->triangles.size() : 0;
  };
  EXPECT_EQ(count_of("body"), 2U);
  EXPECT_EQ(count_of("wheel"), 1U);
  EXPECT_EQ(count_of("left"), 2U);
  EXPECT_EQ(count_of("wheel/left"), 1U);
  EXPECT_EQ(count_of("other"), 0U);
}

TEST(ReadObj, TakesAByteOrderMark) {
  const auto raw = read_obj("\xEF\xBB\xBF" + kThreeVertices + "f 1 2 3\n");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_EQ(raw->mesh.vertices.size(), 3U);
  EXPECT_TRUE(raw->notes.empty());
}

// A polygon of n corners becomes n - 2 triangles, and each takes many times as many bytes as a corner in the file.
TEST(ReadObj, TakesNoMoreTrianglesThanItMay) {
  const std::string faces = "f 1 2 3\nf 1 2 3 1 2 3\n";
  EXPECT_THAT(read_obj(kThreeVertices + faces, AppearanceReading::off, 5)->mesh.triangles, SizeIs(5));
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + faces, AppearanceReading::off, 4)),
              AllOf(HasSubstr("line 5"), HasSubstr("more than 4 triangles")));
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + faces, AppearanceReading::off, 0)),
              AllOf(HasSubstr("line 4"), HasSubstr("more than 0 triangles")));
}

TEST(ReadObj, NamesTheLineOfAFault) {
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + "f 1 2 9\n")), AllOf(HasSubstr("line 4"), HasSubstr("9 is out of range")));
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + "f 0 1 2\n")), HasSubstr("0 is out of range"));
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + "f -1 -2 -4\n")), HasSubstr("-4 is out of range"));
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + "f 1 2 99999999999999999999\n")), HasSubstr("not a vertex number"));
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + "f 1.5 2 3\n")), HasSubstr("'1.5' is not a vertex number"));
  EXPECT_THAT(read_error_of(read_obj(kThreeVertices + "\n\nf 1 2\n")), AllOf(HasSubstr("line 6"), HasSubstr("2 corners")));
  EXPECT_THAT(read_error_of(read_obj("v 0 0\n")), HasSubstr("2 coordinates"));
  EXPECT_THAT(read_error_of(read_obj("v 0 0 nan\n")), HasSubstr("not finite"));
  EXPECT_THAT(read_error_of(read_obj("v 0 0 -inf\n")), HasSubstr("not finite"));
  EXPECT_THAT(read_error_of(read_obj("v 0 0 1e999\n")), HasSubstr("not finite"));
  EXPECT_THAT(read_error_of(read_obj("v 0 0 0x10\n")), HasSubstr("not a number"));
  EXPECT_THAT(read_error_of(read_obj(std::string("v 0\0 0 0\n", 9))), HasSubstr("not text"));
}

TEST(ReadObj, NotesWhatItSkips) {
  const auto raw = read_obj("nonsense here\n" + kThreeVertices + "curv 1 2\nf 1 2 3");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->notes, ElementsAre(AllOf(HasSubstr("line 1"), HasSubstr("'nonsense'")), HasSubstr("2 lines"), HasSubstr("cut short")));
}

TEST(ReadMtl, FillsOnlyTheMaterialsThatTheMeshNames) {
  RawMesh raw;
  raw.appearance.materials.push_back({.name = "b", .colour = {}, .image = {}});
  read_mtl("Kd 1 1 1\nnewmtl a\nKd 1 0 0\nnewmtl b\nKd 0.25 2 oops\nKd 0.25 2 0\n", ".", raw);
  ASSERT_TRUE(raw.appearance.materials[0].colour);
  EXPECT_EQ(*raw.appearance.materials[0].colour, Eigen::Vector3f(0.25F, 1.0F, 0.0F));
}

TEST(ReadMtl, TakesAByteOrderMark) {
  auto raw = read_obj(kThreeVertices + "usemtl red\nf 1 2 3\n", AppearanceReading::on);
  ASSERT_TRUE(raw) << raw.error().what;
  read_mtl("\xEF\xBB\xBFnewmtl red\nKd 1 0 0\n", ".", *raw);
  ASSERT_THAT(raw->appearance.materials, SizeIs(1));
  EXPECT_EQ(raw->appearance.materials[0].colour, Eigen::Vector3f(1, 0, 0));
}

TEST(ReadStl, TakesSeveralSolidsInEitherCase) {
  const std::string one = sample::ascii_stl(sample::tetrahedron());
  std::string two = one;
  for (char& c : two) c = static_cast<char>(std::toupper(c));
  const auto raw = read_stl(one + two);
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(part_names(*raw), ElementsAre("body", "BODY"));
  EXPECT_THAT(raw->mesh.triangles, SizeIs(8));
}

TEST(ReadStl, NamesThePositionOfAFault) {
  std::string quad = sample::ascii_stl(sample::tetrahedron());
  quad.insert(quad.find("  endloop"), "   vertex 0 0 0\n");
  EXPECT_THAT(read_error_of(read_stl(quad)), AllOf(HasSubstr("line 7"), HasSubstr("'vertex' where 'endloop' belongs")));
  std::string nan = sample::ascii_stl(sample::tetrahedron());
  nan.replace(nan.find("1.5"), 3, "nan");
  EXPECT_THAT(read_error_of(read_stl(nan)), AllOf(HasSubstr("line 5"), HasSubstr("not finite")));
  TriangleMesh infinite = sample::tetrahedron();
  infinite.vertices[3].y() = std::numeric_limits<double>::infinity();
  EXPECT_THAT(read_error_of(read_stl(sample::binary_stl(infinite))), AllOf(HasSubstr("triangle 2"), HasSubstr("not finite")));
  EXPECT_THAT(read_error_of(read_stl("neither text nor triangles")), HasSubstr("fewer than"));
}

TEST(ReadStl, TakesAByteOrderMark) {
  const auto raw = read_stl("\xEF\xBB\xBF" + sample::ascii_stl(sample::tetrahedron()));
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_EQ(raw->format, "ASCII STL");
  EXPECT_THAT(raw->mesh.triangles, SizeIs(4));
}

TEST(ReadStl, NotesBytesTooMany) {
  const auto raw = read_stl(sample::binary_stl(sample::tetrahedron()) + "more");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->notes, ElementsAre(HasSubstr("4 bytes")));
}

TEST(ReadPly, SkipsEverythingButGeometry) {
  const std::string text =
      "ply\r\nformat ascii 1.0\r\nobj_info x\r\nelement camera 1\r\nproperty list uchar float lens\r\nelement vertex 4\r\n"
      "property uchar red\r\nproperty double z\r\nproperty list int int ring\r\nproperty double x\r\nproperty double y\r\n"
      "element nothing 4000000000\r\nelement face 1\r\nproperty list uchar uint vertex_index\r\nproperty float quality\r\nend_header\r\n"
      "2 0.5 0.5\r\n255 7 0 0 0\r\n255 7 1 9 1 0\r\n255 7 2 9 9 1 1\r\n255 7 0 0 1\r\n4 0 1 2 3 0.25\r\n";
  const auto raw = read_ply(text);
  ASSERT_TRUE(raw) << raw.error().what;
  ASSERT_THAT(raw->mesh.vertices, SizeIs(4));
  EXPECT_EQ(raw->mesh.vertices[2], Vec3(1, 1, 7));
  EXPECT_THAT(raw->mesh.triangles, SizeIs(2));
}

TEST(ReadPly, TakesAByteOrderMark) {
  const auto raw = read_ply("\xEF\xBB\xBF" + sample::ascii_ply(sample::tetrahedron()));
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->mesh.triangles, SizeIs(4));
}

TEST(ReadPly, TakesNoMoreTrianglesThanItMay) {
  const std::string text = sample::ascii_ply(sample::tetrahedron());
  EXPECT_TRUE(read_ply(text, {}, AppearanceReading::off, 4));
  EXPECT_THAT(read_error_of(read_ply(text, {}, AppearanceReading::off, 3)),
              AllOf(HasSubstr("line 18"), HasSubstr("more than 3 triangles")));
}

// For example, somebody edited the header: without a note, half of the faces would be missing unnoticed.
TEST(ReadPly, NotesWhatFollowsTheLastElement) {
  for (std::string ply : {sample::ascii_ply(sample::tetrahedron()), sample::binary_ply(sample::tetrahedron())}) {
    EXPECT_TRUE(read_ply(ply + (ply.ends_with('\n') ? " \r\n\n" : ""))->notes.empty());
    ply.replace(ply.find("face 4"), 6, "face 2");
    const auto raw = read_ply(ply);
    ASSERT_TRUE(raw) << raw.error().what;
    EXPECT_THAT(raw->mesh.triangles, SizeIs(2));
    EXPECT_THAT(raw->notes,
                ElementsAre(AllOf(HasSubstr(ply.ends_with('\n') ? "16 bytes" : "26 bytes"), HasSubstr("after the last element"))));
  }
}

TEST(ReadPly, NamesThePositionOfAFault) {
  const auto error_with = [](const std::string& from, const std::string& to) {
    std::string text = sample::ascii_ply(sample::tetrahedron());
    text.replace(text.find(from), from.size(), to);
    return read_error_of(read_ply(text));
  };
  EXPECT_THAT(error_with("ply", "plx"), HasSubstr("does not begin with 'ply'"));
  EXPECT_THAT(error_with("ascii", "text"), HasSubstr("unknown format 'text'"));
  EXPECT_THAT(error_with("format ascii 1.0\n", ""), HasSubstr("no 'format'"));
  EXPECT_THAT(error_with("vertex 4", "vertex -4"), AllOf(HasSubstr("line 4"), HasSubstr("'-4'")));
  EXPECT_THAT(error_with("float z", "half z"), HasSubstr("'half'"));
  EXPECT_THAT(error_with("property float z\n", ""), HasSubstr("property 'z'"));
  EXPECT_THAT(error_with("vertex_indices", "corners"), HasSubstr("'vertex_indices'"));
  EXPECT_THAT(error_with("element face", "element strip"), HasSubstr("no 'face' element"));
  EXPECT_THAT(error_with("end_header", "header_end"), HasSubstr("'header_end'"));
  EXPECT_THAT(error_with("0 2.25 0", "0 nan 0"), AllOf(HasSubstr("line 13"), HasSubstr("vertex 2")));
  EXPECT_THAT(error_with("0 2.25 0", "0 x 0"), AllOf(HasSubstr("line 13"), HasSubstr("not a number")));
  EXPECT_THAT(error_with("3 0 1 2", "3 0 1 7"), AllOf(HasSubstr("line 15"), HasSubstr("vertex 7, out of range")));
  EXPECT_THAT(error_with("3 0 1 2", "3 0 1 -1"), HasSubstr("vertex -1, out of range"));
  EXPECT_THAT(error_with("3 0 1 2", "3 0 1 1.5"), HasSubstr("out of range"));
  EXPECT_THAT(error_with("3 0 1 2", "2 0 1"), HasSubstr("2 corners"));
  EXPECT_THAT(error_with("3 0 1 2", "4000000000 0 1 2"), HasSubstr("ends too early"));
}

// In both byte orders, for vertices as well as for lists.
TEST(ReadPly, TakesNumbersOfEveryType) {
  for (const bool swap : {false, true}) {
    std::string bytes = fmt::format(
        "ply\nformat {} 1.0\nelement vertex 3\nproperty char x\nproperty short y\nproperty ushort z\nproperty uchar quality\n"
        "property double weight\nelement face 1\nproperty list uint ushort vertex_indices\nend_header\n",
        swap ? "binary_big_endian" : "binary_little_endian");
    for (const auto& [x, y, z] : {std::array{-128, -300, 65535}, std::array{127, 0, 0}, std::array{1, 32767, 256}}) {
      sample::append(bytes, static_cast<std::int8_t>(x), swap);
      sample::append(bytes, static_cast<std::int16_t>(y), swap);
      sample::append(bytes, static_cast<std::uint16_t>(z), swap);
      sample::append(bytes, std::uint8_t{7}, swap);
      sample::append(bytes, 0.5, swap);
    }
    sample::append(bytes, std::uint32_t{3}, swap);
    for (int v = 0; v < 3; ++v) sample::append(bytes, static_cast<std::uint16_t>(v), swap);
    const auto raw = read_ply(bytes);
    ASSERT_TRUE(raw) << raw.error().what;
    EXPECT_THAT(raw->mesh.vertices, ElementsAre(Vec3(-128, -300, 65535), Vec3(127, 0, 0), Vec3(1, 32767, 256)));
    EXPECT_THAT(raw->mesh.triangles, ElementsAre(Triangle{0, 1, 2}));
    EXPECT_THAT(raw->notes, SizeIs(0));
  }
}

// A star: each second corner is nearer to the middle.
std::vector<Vec3> star(std::size_t corners) {
  std::vector<Vec3> points;
  for (std::size_t k = 0; k < corners; ++k) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(corners);
    points.push_back((k % 2 == 0 ? 1.0 : 0.9) * Vec3(std::cos(angle), std::sin(angle), 0.0));
  }
  return points;
}

TEST(HollowPolygons, HaveNoMoreCornersThanTheyMay) {
  for (const std::size_t corners : {kMaxPolygonCorners, kMaxPolygonCorners + 2}) {
    std::string obj;
    std::string face = "f";
    std::string ply = fmt::format(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
        "property list ushort int vertex_indices\nend_header\n",
        corners);
    std::string list = fmt::format("{}", corners);
    for (const Vec3& p : star(corners)) {
      obj += fmt::format("v {} {} 0\n", p.x(), p.y());
      ply += fmt::format("{} {} 0\n", p.x(), p.y());
    }
    for (std::size_t k = 0; k < corners; ++k) {
      face += fmt::format(" {}", k + 1);
      list += fmt::format(" {}", k);
    }
    const auto from_obj = read_obj(obj + face + "\n");
    const auto from_ply = read_ply(ply + list + "\n");
    EXPECT_EQ(from_obj.has_value(), corners == kMaxPolygonCorners);
    EXPECT_EQ(from_ply.has_value(), corners == kMaxPolygonCorners);
    if (from_obj || from_ply) continue;
    EXPECT_THAT(from_obj.error().what, HasSubstr("line 1027: a hollow polygon has 1026 corners, more than 1024: triangulate it"));
    EXPECT_THAT(from_ply.error().what, HasSubstr("face 0 is hollow and has more than 1024 corners: triangulate it"));
  }
}

TEST(ReadPly, NamesTheByteOfAFaultInBinary) {
  std::string bytes = sample::binary_ply(sample::tetrahedron());
  const std::int32_t index = 70000;
  std::memcpy(bytes.data() + bytes.size() - 4, &index, sizeof index);
  EXPECT_THAT(read_error_of(read_ply(bytes)), AllOf(HasSubstr(fmt::format("byte {}", bytes.size())), HasSubstr("vertex 70000")));
}

// The error for a glTF file in which the first `from` is replaced by `to`.
std::string gltf_error_with(const std::string& from, const std::string& to) {
  std::string text = sample::inline_gltf(sample::tetrahedron());
  text.replace(text.find(from), from.size(), to);
  return read_error_of(read_gltf(text, "."));
}

TEST(ReadGltf, SaysWhatIsWrong) {
  EXPECT_THAT(gltf_error_with("\"2.0\"", "\"1.0\""), HasSubstr("version '1.0'"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":5"), HasSubstr("nodes[0].mesh is 5, out of range"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":-1"), HasSubstr("nodes[0].mesh is -1"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":\"x\""), HasSubstr("not a number"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":0,\"children\":[0]"), HasSubstr("below itself"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":0,\"children\":[7]"), HasSubstr("out of range"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":0,\"rotation\":[0,0,0,0]"), HasSubstr("rotation is zero"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":0,\"matrix\":[1,2]"), HasSubstr("16 numbers"));
  EXPECT_THAT(gltf_error_with("\"mesh\":0", "\"mesh\":0,\"matrix\":[1,0,0,0.5, 0,1,0,0, 0,0,1,0, 0,0,0,1]"), HasSubstr("is not affine"));
  EXPECT_THAT(gltf_error_with("\"indices\":1", "\"indices\":9"), HasSubstr("out of range"));
  EXPECT_THAT(gltf_error_with("\"indices\":1", "\"indices\":0"), HasSubstr("not of type SCALAR"));
  EXPECT_THAT(gltf_error_with("5126", "5130"), HasSubstr("componentType is 5130"));
  EXPECT_THAT(gltf_error_with("\"count\":12", "\"count\":11"), HasSubstr("multiple of 3"));
  EXPECT_THAT(gltf_error_with("\"bufferView\":1", "\"bufferView\":1,\"sparse\":{}"), HasSubstr("sparse"));
  EXPECT_THAT(gltf_error_with("\"bufferView\":1,", "\"bufferView\":\"x\","), HasSubstr("bufferView is missing"));
  EXPECT_THAT(gltf_error_with("\"byteOffset\":48", "\"byteOffset\":480"), HasSubstr("cut short"));
  EXPECT_THAT(gltf_error_with("\"byteOffset\":48", "\"byteOffset\":80"), HasSubstr("ends at byte 104 but its buffer has 72: cut short"));
  EXPECT_THAT(gltf_error_with("\"byteLength\":48}", "\"byteLength\":48,\"byteStride\":4}"), HasSubstr("its items overlap (stride 4)"));
  EXPECT_THAT(gltf_error_with("base64,", "base64,!"), HasSubstr("not base64"));
  EXPECT_THAT(gltf_error_with("data:application", "http://application"), HasSubstr("on the network"));
  EXPECT_THAT(gltf_error_with("{\"asset\"", "{\"extensionsRequired\":[\"NV_micromesh\"],\"asset\""), HasSubstr("NV_micromesh"));
  TriangleMesh mesh = sample::tetrahedron();
  mesh.triangles[1][2] = 4;
  EXPECT_THAT(read_error_of(read_gltf(sample::inline_gltf(mesh), ".")), AllOf(HasSubstr("index 5 is 4"), HasSubstr("4 vertices")));
  mesh = sample::tetrahedron();
  mesh.vertices[2].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(read_error_of(read_gltf(sample::inline_gltf(mesh), ".")), AllOf(HasSubstr("vertex 2"), HasSubstr("not finite")));
}

TEST(ReadGltf, AFileWithoutAJsonChunkSaysSo) {
  const TriangleMesh mesh = sample::tetrahedron();
  std::string bytes = sample::glb(sample::gltf_json(mesh, ""), sample::gltf_buffer(mesh));
  bytes.replace(bytes.find("JSON"), 4, "NONE");
  EXPECT_THAT(read_error_of(read_glb(bytes, ".")), HasSubstr("has no JSON chunk"));
}

TEST(ReadGltf, SurvivesDeepNesting) {
  EXPECT_THAT(read_error_of(read_gltf(std::string(1000000, '['), ".")), HasSubstr("JSON is broken"));
  std::string nodes = "[";
  for (int n = 1; n < 50000; ++n) nodes += fmt::format(R"({{"children":[{}]}},)", n);
  nodes += R"({"mesh":0}])";
  const TriangleMesh mesh = sample::tetrahedron();
  const std::string json = sample::gltf_json(mesh, "", nodes);
  const std::string bytes = sample::glb(json, sample::gltf_buffer(mesh));
  const auto raw = read_glb(bytes, ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->mesh.triangles, SizeIs(4));
}

TEST(ReadGltf, AppliesTransformsDownTheTreeToEveryInstance) {
  const TriangleMesh mesh = sample::tetrahedron();
  // Two instances: one turned 90 degrees about z, doubled and moved, under a moved parent; one mirrored in x by a matrix.
  const std::string nodes =
      R"([{"translation":[10,0,0],"children":[1]},)"
      R"({"mesh":0,"name":"turned","translation":[0,5,0],"rotation":[0,0,0.7071067811865476,0.7071067811865476],"scale":[2,2,2]},)"
      R"({"mesh":0,"name":"mirrored","matrix":[-1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,3,1]},{"mesh":0,"name":"in no scene"}])";
  const auto raw = read_glb(sample::glb(sample::gltf_json(mesh, "", nodes, "[0,2]"), sample::gltf_buffer(mesh)), ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(part_names(*raw), ElementsAre("turned", "mirrored"));
  ASSERT_THAT(raw->mesh.triangles, SizeIs(8));
  EXPECT_LT((raw->mesh.vertices[1] - Vec3(10, 8, 0)).norm(), 1e-12);
  EXPECT_LT((raw->mesh.vertices[4 + 1] - Vec3(-1.5, 0, 3)).norm(), 1e-12);
  EXPECT_EQ(raw->mesh.triangles[4], (Triangle{4, 6, 5})) << "a mirror turns the winding";
}

TEST(ReadGltf, TakesNoMoreTrianglesThanItMay) {
  const std::string text = sample::inline_gltf(sample::tetrahedron());
  EXPECT_TRUE(read_gltf(text, ".", 4));
  EXPECT_EQ(read_error_of(read_gltf(text, ".", 3)), "meshes[0].primitives[0] has more than 3 triangles: simplify it");
  EXPECT_EQ(read_error_of(read_gltf(text, ".", 1)), "meshes[0].primitives[0] has more than 1 triangles: simplify it") << "four vertices";
}

// If a file has no scenes, each node without a parent is shown, once.
TEST(ReadGltf, OfAFileWithoutScenesTheRootsAreShown) {
  const auto read = [](const std::string& children) {
    const std::string triangle(36, '\0');
    return read_glb(sample::glb(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36}],"bufferViews":[{"buffer":0,"byteLength":36}],)"
                                R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],)"
                                R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],)"
                                R"("nodes":[{"mesh":0},{"children":[)" +
                                    children + R"(],"translation":[1,0,0]}]})",
                                triangle),
                    ".");
  };
  const auto raw = read("0");
  ASSERT_TRUE(raw) << raw.error().what;
  ASSERT_THAT(raw->mesh.vertices, SizeIs(3));
  EXPECT_EQ(raw->mesh.vertices[0], Vec3(1, 0, 0));
  EXPECT_THAT(read_error_of(read("7")), HasSubstr("a child of nodes[1] is 7, out of range: there are 2"));
}

TEST(ReadGltf, TakesStripsFansAndNoIndices) {
  const TriangleMesh mesh = sample::tetrahedron();
  const auto read_mode = [&](const std::string& mode) {
    std::string json = sample::gltf_json(mesh, "");
    json.replace(json.find(",\"indices\":1"), 12, ",\"mode\":" + mode);
    return read_glb(sample::glb(json, sample::gltf_buffer(mesh)), ".");
  };
  const auto strip = read_mode("5");
  ASSERT_TRUE(strip) << strip.error().what;
  EXPECT_THAT(strip->mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{1, 3, 2}));
  const auto fan = read_mode("6");
  ASSERT_TRUE(fan) << fan.error().what;
  EXPECT_THAT(fan->mesh.triangles, ElementsAre(Triangle{0, 1, 2}, Triangle{0, 2, 3}));
  const auto points = read_mode("0");
  ASSERT_TRUE(points) << points.error().what;
  EXPECT_THAT(points->mesh.triangles, SizeIs(0));
  EXPECT_THAT(points->notes, ElementsAre(HasSubstr("1 primitives of points")));
}

TEST(ReadGltf, TakesQuantizedPositions) {
  std::string buffer;
  for (const int c : {0, 0, 0, 0, 127, 0, 0, 0, 0, -127, 0, 0}) sample::append(buffer, static_cast<std::int8_t>(c));
  const std::string json =
      R"({"asset":{"version":"2.0"},"extensionsRequired":["KHR_mesh_quantization"],"nodes":[{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5120,"normalized":true,)"
      R"("count":3,"type":"VEC3"}],"bufferViews":[{"buffer":0,"byteLength":12,"byteStride":4}],"buffers":[{"byteLength":12}]})";
  const auto raw = read_glb(sample::glb(json, buffer), ".");
  ASSERT_TRUE(raw) << raw.error().what;
  EXPECT_THAT(raw->mesh.vertices, ElementsAre(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, -1, 0)));
}

TEST(ReadGlb, SaysWhatIsWrong) {
  std::string bytes = sample::glb(sample::gltf_json(sample::tetrahedron(), ""), sample::gltf_buffer(sample::tetrahedron()));
  EXPECT_THAT(read_error_of(read_glb("glTX" + bytes.substr(4), ".")), HasSubstr("does not begin with 'glTF'"));
  std::string version = bytes;
  version[4] = 1;
  EXPECT_THAT(read_error_of(read_glb(version, ".")), HasSubstr("version 1"));
  std::string chunk = bytes;
  chunk[15] = 0x7f;
  EXPECT_THAT(read_error_of(read_glb(chunk, ".")), HasSubstr("reaches past the end"));
}

}  // namespace
}  // namespace hapton
