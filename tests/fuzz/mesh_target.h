#pragma once

#include <string_view>

#include "scene/raw_mesh.h"
#include "scene/weld.h"
#include "tests/fuzz/fuzz_target.h"

namespace hapton::fuzz {

inline std::string_view text_of(std::span<const std::uint8_t> bytes) { return {reinterpret_cast<const char*>(bytes.data()), bytes.size()}; }

inline void require_sound(const TriangleMesh& mesh) {
  for (const Vec3& vertex : mesh.vertices) require(vertex.allFinite());
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) require(corner < mesh.vertices.size());
  }
}

// What every reader promises: one line that says what is wrong, or a mesh with every coordinate finite and every index in range.
inline void require_sound(Result<RawMesh> raw) {
  if (!raw) {
    require(!raw.error().what.empty());
    require(raw.error().what.find('\n') == std::string::npos);
    return;
  }
  require_sound(raw->mesh);
  std::size_t next = 0;
  for (const MeshPart& part : raw->parts) {
    require(part.first_triangle == next);
    next += part.triangle_count;
  }
  require(next == raw->mesh.triangles.size());
  if (raw->mesh.triangles.empty()) return;
  weld_vertices(raw->mesh);
  require_sound(raw->mesh);
}

// No file lies there, so that a mesh can name no other.
constexpr const char* kNoFolder = "/nonexistent/hapton";

}  // namespace hapton::fuzz
