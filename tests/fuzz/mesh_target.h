#pragma once

#include <string_view>

#include "core/geometry/seal_cracks.h"
#include "scene/material_reader.h"
#include "scene/mesh_report.h"
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

// What follows the reading of a mesh: its flaws are counted, reported, and its cracks sealed.
inline void require_touchable(const TriangleMesh& mesh) {
  require(to_text(find_flaws(mesh)).find('\n') == std::string::npos);
  SealReport report;
  const TriangleMesh sealed = seal_cracks(mesh, report);
  require_sound(sealed);
  require(report.boundary_edges_left <= report.boundary_edges);
  require(report.describe().find('\n') == std::string::npos);
}

// There are as many appearances as triangles, or none; every index is in range and every texture coordinate is finite.
inline void require_sound(const MeshAppearance& appearance, std::size_t triangles) {
  require(appearance.triangles.empty() || appearance.triangles.size() == triangles);
  for (const VisualMaterial& material : appearance.materials) {
    require(!material.image || *material.image < appearance.images.size());
    require(!material.colour || (material.colour->array() >= 0.0F && material.colour->array() <= 1.0F).all());
  }
  for (const TriangleAppearance& triangle : appearance.triangles) {
    require(triangle.material == TriangleAppearance::kNoMaterial || triangle.material < appearance.materials.size());
    for (const CornerAppearance& corner : triangle.corners) require(corner.texcoord.allFinite());
  }
}

// The same for haptic materials and maps: every image that a material uses exists, and so does the material of every triangle.
inline void require_sound(const MeshHaptics& haptics, std::size_t triangles) {
  require(haptics.maps.triangles.empty() || haptics.maps.triangles.size() == triangles);
  for (const HapticMaterial& material : haptics.materials) {
    for (const auto& image : {material.height, material.stiffness, material.friction})
      require(!image || *image < haptics.maps.images.size());
  }
  for (const TriangleAppearance& triangle : haptics.maps.triangles) {
    if (triangle.material == TriangleAppearance::kNoMaterial) continue;
    require(triangle.material < haptics.materials.size());
    for (const CornerAppearance& corner : triangle.corners) require(corner.texcoord.allFinite());
    const auto read = read_material(haptics.materials[triangle.material], haptics.maps, "file");
    require(read ? read->material.stiffness_n_per_m > 0.0 : read.error().what.find('\n') == std::string::npos);
  }
}

// The promise of every reader: one line that says what is wrong, or a mesh with every coordinate finite and every index in range.
inline void require_sound(Result<RawMesh> raw) {
  if (!raw) {
    require(!raw.error().what.empty());
    require(raw.error().what.find('\n') == std::string::npos);
    return;
  }
  require_sound(raw->mesh);
  raw->complete_appearance();
  require_sound(raw->appearance, raw->mesh.triangles.size());
  require_sound(raw->haptics, raw->mesh.triangles.size());
  std::size_t next = 0;
  for (const MeshPart& part : raw->parts) {
    require(part.first_triangle == next);
    next += part.triangle_count;
  }
  require(next == raw->mesh.triangles.size());
  if (raw->mesh.triangles.empty()) return;
  weld_vertices(raw->mesh);
  require_sound(raw->mesh);
  require_touchable(raw->mesh);
}

// This folder does not exist, so that a mesh cannot make the reader open another file.
constexpr const char* kNoFolder = "/nonexistent/hapton";

// The limit for files with instances, in which a few bytes can request any number of triangles.
constexpr std::size_t kMaxTriangles = 1U << 16;

}  // namespace hapton::fuzz
