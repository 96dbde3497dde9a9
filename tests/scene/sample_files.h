#pragma once

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>

#include "core/geometry/triangle_mesh.h"

// One mesh in the bytes of every format that Hapton reads. This code is independent of the readers, so that it can test them.
namespace hapton::sample {

// The coordinates of the tetrahedron are exact in single precision and have few decimal places.
inline TriangleMesh tetrahedron() {
  return {.vertices = {{0, 0, 0}, {1.5, 0, 0}, {0, 2.25, 0}, {0, 0, -0.125}}, .triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {2, 3, 0}}};
}

template <class T>
void append(std::string& bytes, T value, bool swap = false) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), &value, sizeof value);
  if (swap) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

inline std::string obj(const TriangleMesh& mesh) {
  std::string text = "# a comment\no body\n";
  for (const Vec3& v : mesh.vertices) text += fmt::format("v {} {} {}\n", v.x(), v.y(), v.z());
  for (const Triangle& t : mesh.triangles) text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

inline std::string ascii_stl(const TriangleMesh& mesh) {
  std::string text = "solid body\n";
  for (const Triangle& t : mesh.triangles) {
    text += " facet normal 0 0 1\n  outer loop\n";
    for (const std::uint32_t v : t)
      text += fmt::format("   vertex {} {} {}\n", mesh.vertices[v].x(), mesh.vertices[v].y(), mesh.vertices[v].z());
    text += "  endloop\n endfacet\n";
  }
  return text + "endsolid body\n";
}

inline std::string binary_stl(const TriangleMesh& mesh, std::string header = "made by a test") {
  header.resize(80, ' ');
  append(header, static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& t : mesh.triangles) {
    header.append(12, '\0');
    for (const std::uint32_t v : t) {
      for (int axis = 0; axis < 3; ++axis) append(header, static_cast<float>(mesh.vertices[v][axis]));
    }
    header.append(2, '\0');
  }
  return header;
}

inline std::string ply_header(const std::string& format, std::size_t vertices, std::size_t faces) {
  return fmt::format(
      "ply\nformat {} 1.0\ncomment made by a test\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      format, vertices, faces);
}

inline std::string ascii_ply(const TriangleMesh& mesh) {
  std::string text = ply_header("ascii", mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& v : mesh.vertices) text += fmt::format("{} {} {}\n", v.x(), v.y(), v.z());
  for (const Triangle& t : mesh.triangles) text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
  return text;
}

inline std::string binary_ply(const TriangleMesh& mesh, bool big_endian = false) {
  std::string bytes = ply_header(big_endian ? "binary_big_endian" : "binary_little_endian", mesh.vertices.size(), mesh.triangles.size());
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) append(bytes, static_cast<float>(v[axis]), big_endian);
  }
  for (const Triangle& t : mesh.triangles) {
    bytes.push_back(3);
    for (const std::uint32_t v : t) append(bytes, static_cast<std::int32_t>(v), big_endian);
  }
  return bytes;
}

// Positions, then 16-bit indices.
inline std::string gltf_buffer(const TriangleMesh& mesh) {
  std::string bytes;
  for (const Vec3& v : mesh.vertices) {
    for (int axis = 0; axis < 3; ++axis) append(bytes, static_cast<float>(v[axis]));
  }
  for (const Triangle& t : mesh.triangles) {
    for (const std::uint32_t v : t) append(bytes, static_cast<std::uint16_t>(v));
  }
  return bytes;
}

// buffer: further JSON members of buffers[0], each followed by a comma. nodes: the array of nodes, which use meshes[0].
inline std::string gltf_json(const TriangleMesh& mesh, const std::string& buffer,
                             const std::string& nodes = R"([{"mesh":0,"name":"body"}])", const std::string& roots = "[0]") {
  const std::size_t position_bytes = 12 * mesh.vertices.size();
  const std::size_t index_bytes = 6 * mesh.triangles.size();
  std::string text = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":ROOTS}],"nodes":NODES,)"
                     R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],)";
  text.replace(text.find("ROOTS"), 5, roots);
  text.replace(text.find("NODES"), 5, nodes);
  text += fmt::format(R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"VEC3"}},)", mesh.vertices.size());
  text += fmt::format(R"({{"bufferView":1,"componentType":5123,"count":{},"type":"SCALAR"}}],)", 3 * mesh.triangles.size());
  text += fmt::format(R"("bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],)", position_bytes,
                      position_bytes, index_bytes);
  return text + fmt::format(R"("buffers":[{{{}"byteLength":{}}}]}})", buffer, position_bytes + index_bytes);
}

inline std::string glb(const std::string& json, const std::string& buffer) {
  std::string padded_json = json;
  padded_json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string padded_buffer = buffer;
  padded_buffer.resize((buffer.size() + 3) / 4 * 4, '\0');
  std::string bytes = "glTF";
  append(bytes, std::uint32_t{2});
  append(bytes, static_cast<std::uint32_t>(12 + 8 + padded_json.size() + 8 + padded_buffer.size()));
  append(bytes, static_cast<std::uint32_t>(padded_json.size()));
  bytes += "JSON" + padded_json;
  append(bytes, static_cast<std::uint32_t>(padded_buffer.size()));
  return bytes + std::string("BIN\0", 4) + padded_buffer;
}

inline std::string base64(const std::string& bytes) {
  static constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t group_size = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (k < group_size ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += k <= group_size ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

inline std::string inline_gltf(const TriangleMesh& mesh) {
  return gltf_json(mesh, R"("uri":"data:application/octet-stream;base64,)" + base64(gltf_buffer(mesh)) + R"(",)");
}

}  // namespace hapton::sample
