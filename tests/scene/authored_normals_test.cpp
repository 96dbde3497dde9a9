// Vertex normals from a file: every format that can have them is read, and they stay right through poses, parts and repairs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/corner_normals.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/repair_mesh.h"
#include "scene/mesh_file.h"
#include "scene/mesh_report.h"
#include "scene/scene_file.h"
#include "tests/scene/sample_files.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

using Normals = std::vector<Eigen::Vector3f>;

// Radial normals of length 2: the readers keep the length that a file gives, except the glTF reader.
Normals radial_normals(const TriangleMesh& mesh) {
  Normals normals;
  for (const Vec3& v : mesh.vertices) normals.emplace_back((2.0 * v.normalized()).cast<float>());
  return normals;
}

TriangleMesh ball() { return make_icosphere(1.0, 1); }

std::string obj_of(const TriangleMesh& mesh, const Normals& normals) {
  std::string text;
  for (const Vec3& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const auto& n : normals) text += fmt::format("vn {} {} {}\n", n.x(), n.y(), n.z());
  for (const Triangle& t : mesh.triangles) text += fmt::format("f {0}//{0} {1}/7/{1} {2}//{2}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

std::string ply_of(const TriangleMesh& mesh, const Normals& normals) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float nx\nproperty float x\nproperty float y\nproperty float z\nproperty uchar "
      "red\n"
      "property float ny\nproperty float nz\nelement face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Vec3& v = mesh.vertices[i];
    text += fmt::format("{} {} {} {} 200 {} {}\n", normals[i].x(), v.x(), v.y(), v.z(), normals[i].y(), normals[i].z());
  }
  for (const Triangle& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return text;
}

// The mesh with its normals as a glTF file. transform: further JSON members of its only node, each preceded by a comma.
std::string gltf_of(const TriangleMesh& mesh, const Normals& normals, const std::string& transform) {
  std::string bytes = sample::gltf_buffer(mesh);
  const std::size_t byte_count_before = bytes.size();
  bytes.resize((byte_count_before + 3) / 4 * 4, '\0');
  const std::size_t offset = bytes.size();
  for (const auto& n : normals) {
    for (int axis = 0; axis < 3; ++axis) sample::append(bytes, n[axis]);
  }
  std::string json = sample::gltf_json(mesh, R"("uri":"data:application/octet-stream;base64,)" + sample::base64(bytes) + R"(",)",
                                       R"([{"mesh":0,"name":"body")" + transform + "}]");
  const auto insert_after = [&](const std::string& at, const std::string& what) {
    const auto place = json.find(at);
    ASSERT_NE(place, std::string::npos);
    json.insert(place + at.size(), what);
  };
  insert_after(R"("POSITION":0)", R"(,"NORMAL":2)");
  insert_after(R"("type":"SCALAR"})", fmt::format(R"(,{{"bufferView":2,"componentType":5126,"count":{},"type":"VEC3"}})", normals.size()));
  const std::string views = fmt::format(R"("byteLength":{}}}])", 6 * mesh.triangles.size());
  json.replace(json.find(views), views.size(),
               fmt::format(R"("byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}])", 6 * mesh.triangles.size(), offset,
                           12 * normals.size()));
  const std::string length = fmt::format(R"("byteLength":{}}}]}})", byte_count_before);
  json.replace(json.find(length), length.size(), fmt::format(R"("byteLength":{}}}]}})", bytes.size()));
  return json;
}

void expect_radial(const TriangleMesh& mesh) {
  ASSERT_TRUE(mesh.has_authored_normals());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 normal = mesh.authored_normals[t][k].cast<double>().normalized();
      EXPECT_LT((normal - mesh.corner(t, k).normalized()).norm(), 1e-6) << "triangle " << t << ", corner " << k;
    }
  }
  EXPECT_EQ(count_authored_normals(mesh).used, 3 * mesh.triangles.size());
}

TEST(AuthoredNormals, AreReadFromEveryFormatThatHasThem) {
  const ScratchFolder folder;
  const TriangleMesh mesh = ball();
  const Normals normals = radial_normals(mesh);
  for (const auto& [name, bytes] : {std::pair<std::string, std::string>{"a.obj", obj_of(mesh, normals)},
                                    {"a.ply", ply_of(mesh, normals)},
                                    {"a.gltf", gltf_of(mesh, normals, "")},
                                    {"mirrored.gltf", gltf_of(mesh, normals, R"(,"scale":[-1,1,1],"rotation":[0,0,0.6,0.8])")}}) {
    SCOPED_TRACE(name);
    const auto file = load_mesh_file(folder.write(name, bytes));
    ASSERT_TRUE(file) << file.error().what;
    EXPECT_THAT(file->notes, testing::IsEmpty());
    expect_radial(file->mesh);
  }
}

// A sphere stretched by the factor a along x is an ellipsoid: the x component of its normals is x / a^2.
TEST(AuthoredNormals, StayAtRightAnglesToAStretchedSurface) {
  const ScratchFolder folder;
  const TriangleMesh mesh = ball();
  const auto file = load_mesh_file(folder.write("a.gltf", gltf_of(mesh, radial_normals(mesh), R"(,"scale":[3,1,1])")));
  ASSERT_TRUE(file) << file.error().what;
  ASSERT_TRUE(file->mesh.has_authored_normals());
  for (std::size_t t = 0; t < file->mesh.triangles.size(); ++t) {
    const Vec3 p = file->mesh.corner(t, 0);
    EXPECT_LT((file->mesh.authored_normals[t][0].cast<double>() - Vec3(p.x() / 9.0, p.y(), p.z()).normalized()).norm(), 1e-5);
  }
}

TEST(AuthoredNormals, AFileWithoutThemHasNone) {
  const ScratchFolder folder;
  const auto file = load_mesh_file(folder.write("a.obj", sample::obj(ball())));
  ASSERT_TRUE(file);
  EXPECT_FALSE(file->mesh.has_authored_normals());
  EXPECT_TRUE(file->mesh.authored_normals.empty());
}

TEST(AuthoredNormals, OfAPolygonFollowItsCorners) {
  const ScratchFolder folder;
  // A concave pentagon, which is cut by ear clipping; the x component of each normal tells to which corner it belongs.
  const auto file = load_mesh_file(folder.write(
      "a.obj",
      "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nvn 0 0 1\nvn .1 0 1\nvn .2 0 1\nvn .3 0 1\nvn .4 0 1\nf 1//1 2//2 3//3 4//4 5//5\n"));
  ASSERT_TRUE(file) << file.error().what;
  ASSERT_EQ(file->mesh.triangles.size(), 3U);
  ASSERT_TRUE(file->mesh.has_authored_normals());
  const std::vector<Vec3> corners = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 1, 0}, {0, 4, 0}};
  for (std::size_t t = 0; t < 3; ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto i = std::find(corners.begin(), corners.end(), file->mesh.corner(t, k)) - corners.begin();
      EXPECT_NEAR(file->mesh.authored_normals[t][k].x(), 0.1 * static_cast<double>(i), 1e-6);
    }
  }
}

TEST(AuthoredNormals, UnreadableOnesAreNotedAndLeftOut) {
  const ScratchFolder folder;
  const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const auto file = load_mesh_file(folder.write("a.obj", corners + "vn 0 0 one\nvn 0 0 nan\nvn 0 0 1\nf 1//1 2//2 3//9\nf 1//3 2//-1 3\n"));
  ASSERT_TRUE(file) << file.error().what;
  EXPECT_THAT(file->notes, testing::Contains(testing::HasSubstr("2 vertex normals cannot be read")));
  const AuthoredNormalReport report = count_authored_normals(file->mesh);
  EXPECT_EQ(report.used, 2U);
  // The accessor is of the wrong type.
  const TriangleMesh mesh = ball();
  std::string gltf = gltf_of(mesh, radial_normals(mesh), "");
  gltf.replace(gltf.find("\"NORMAL\":2"), 10, "\"NORMAL\":1");
  const auto bad = load_mesh_file(folder.write("b.gltf", gltf));
  ASSERT_TRUE(bad) << bad.error().what;
  EXPECT_FALSE(bad->mesh.has_authored_normals());
  EXPECT_THAT(bad->notes, testing::Contains(testing::HasSubstr("normals of 1 primitives cannot be read")));
}

TEST(AuthoredNormals, GoWithPartsAndPoses) {
  const ScratchFolder folder;
  const TriangleMesh mesh = ball();
  const std::string bytes = obj_of(mesh, radial_normals(mesh));
  const auto faces = bytes.find("f ");
  folder.write("a.obj", bytes.substr(0, faces) + "o first\nf 1 2 3\no body\n" + bytes.substr(faces));
  const auto scene = folder.write("a.toml", "[[object]]\nmesh = \"a.obj\"\npart = \"body\"\nscale = 0.1\nrotation_deg = [30, 40, 50]\n");
  const auto loaded = load_scene(scene);
  ASSERT_TRUE(loaded) << loaded.error().what;
  expect_radial(*loaded->objects[0].mesh);
}

TEST(AuthoredNormals, StayWithTheirTrianglesWhenAMeshIsRepaired) {
  TriangleMesh mesh = ball();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Eigen::Vector3f, 3> normals;
    for (int k = 0; k < 3; ++k) normals[k] = mesh.corner(t, k).cast<float>();
    mesh.authored_normals.push_back(normals);
  }
  const auto duplicate = mesh.triangles[4];
  mesh.triangles.insert(mesh.triangles.begin() + 9, duplicate);
  mesh.authored_normals.insert(mesh.authored_normals.begin() + 9, mesh.authored_normals[4]);
  std::swap(mesh.triangles[20][1], mesh.triangles[20][2]);
  std::swap(mesh.authored_normals[20][1], mesh.authored_normals[20][2]);
  RepairReport report;
  const TriangleMesh repaired = repair_mesh(mesh, report);
  EXPECT_EQ(report.dropped_duplicates, 1U);
  EXPECT_EQ(report.turned, 1U);
  expect_radial(repaired);
}

TEST(AuthoredNormals, InfoSaysWhetherTheyAreThereAndUsed) {
  const ScratchFolder folder;
  const TriangleMesh mesh = ball();
  Normals normals = radial_normals(mesh);
  normals[0] = -normals[0];
  const auto report = make_mesh_report(folder.write("a.obj", obj_of(mesh, normals)), std::nullopt);
  ASSERT_TRUE(report) << report.error().what;
  EXPECT_THAT(to_text(*report), testing::ContainsRegex("authored normals +of 240 corners, 23[0-9] used by force shading"));
  EXPECT_THAT(to_json(*report), testing::HasSubstr("\"authored_normals\""));
  const auto none = make_mesh_report(folder.write("b.obj", sample::obj(mesh)), std::nullopt);
  EXPECT_THAT(to_text(*none), testing::ContainsRegex("authored normals +none"));
}

}  // namespace
}  // namespace hapton
