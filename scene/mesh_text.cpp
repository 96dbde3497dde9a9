#include "scene/mesh_text.h"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdint>
#include <cstring>

#include <fmt/format.h>

namespace hapton {
namespace {

static_assert(std::endian::native == std::endian::little, "STL and this PLY are little-endian");

template <class Value>
void append_bytes(std::string& to, const Value& value) {
  char bytes[sizeof(Value)];
  std::memcpy(bytes, &value, sizeof(Value));
  to.append(bytes, sizeof(Value));
}

void append_floats(std::string& to, const Vec3& v) {
  for (int axis = 0; axis < 3; ++axis) append_bytes(to, static_cast<float>(v[axis]));
}

std::string write_stl(const TriangleMesh& mesh) {
  constexpr std::size_t kHeaderBytes = 80;
  std::string text = "binary STL of hapton, metres";
  text.resize(kHeaderBytes, ' ');
  append_bytes(text, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 across = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0));
    append_floats(text, across.norm() > 0.0 ? Vec3(across.normalized()) : Vec3(Vec3::Zero()));
    for (int k = 0; k < 3; ++k) append_floats(text, mesh.corner(t, k));
    append_bytes(text, std::uint16_t{0});
  }
  return text;
}

std::string write_obj(const TriangleMesh& mesh) {
  std::string text = "# in metres\n";
  for (const Vec3& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const Triangle& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

std::string write_ply(const TriangleMesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment in metres\nelement vertex {}\nproperty double x\nproperty double y\nproperty double "
      "z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) append_bytes(text, v[axis]);
  }
  for (const Triangle& t : mesh.triangles) {
    append_bytes(text, std::uint8_t{3});
    for (int k = 0; k < 3; ++k) append_bytes(text, static_cast<std::int32_t>(t[static_cast<std::size_t>(k)]));
  }
  return text;
}

}  // namespace

Result<MeshTextFormat> find_mesh_format(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (ending == ".stl") return MeshTextFormat::stl;
  if (ending == ".obj") return MeshTextFormat::obj;
  if (ending == ".ply") return MeshTextFormat::ply;
  return fail("{}: a mesh is written as STL, OBJ or PLY; give it a name that ends in .stl, .obj or .ply", file.string());
}

std::string write_mesh(const TriangleMesh& mesh, MeshTextFormat format) {
  if (format == MeshTextFormat::stl) return write_stl(mesh);
  return format == MeshTextFormat::obj ? write_obj(mesh) : write_ply(mesh);
}

}  // namespace hapton
