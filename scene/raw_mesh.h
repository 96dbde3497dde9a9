#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_file.h"

namespace hapton {

// What a reader found, before welding: the file's own units. Every index in range, every coordinate finite.
struct RawMesh {
  std::string format;
  TriangleMesh mesh;
  std::vector<MeshPart> parts;
  std::vector<std::string> notes;

  // Every triangle from here on belongs to a part of this name.
  void begin_part(std::string name);
  // Counts the last part's triangles; parts without any go.
  void end_parts();

  // Appends a polygon's triangles as triangulate_polygon does. normals: the authored ones of its corners, in their order; empty when there
  // are none. False, and nothing appended, when it has too many corners.
  bool add_polygon(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> normals);
  // The same for one triangle.
  void add_triangle(const Triangle& triangle, const std::array<Eigen::Vector3f, 3>& normals);
  // Once at the end: triangles that were added without normals have zero ones, when others have some.
  void end_normals();
};

// One strict reader a format; bytes is the whole file. Errors say where in the file, not which file. RT: set-up only.
Result<RawMesh> read_obj(std::string_view bytes);
Result<RawMesh> read_stl(std::string_view bytes);
Result<RawMesh> read_ply(std::string_view bytes);
// folder: where buffers with relative addresses are. max_triangles: of all instances together; with more the file is refused.
Result<RawMesh> read_gltf(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles = kMaxMeshTriangles);
Result<RawMesh> read_glb(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles = kMaxMeshTriangles);

}  // namespace hapton
