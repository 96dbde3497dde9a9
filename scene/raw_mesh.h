#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_appearance.h"
#include "scene/mesh_file.h"
#include "scene/mesh_haptics.h"

namespace hapton {

// Appearance of a polygon: its material and its corners, in their order.
struct PolygonAppearance {
  std::uint32_t material = TriangleAppearance::kNoMaterial;
  bool has_colours = false;
  std::span<const CornerAppearance> corners;
};

// What a reader found, before welding, in the file's own units. Every index is in range, every coordinate finite.
struct RawMesh {
  std::string format;
  TriangleMesh mesh;
  std::vector<MeshPart> parts;
  std::vector<std::string> notes;
  MeshAppearance appearance = {};                 // without triangles if it was not requested or the file has none
  MeshHaptics haptics = {};                       // of glTF files
  std::vector<MeshAnimation> animations = {};     // of glTF files
  std::map<std::size_t, MeshMorphs> morphs = {};  // of glTF files, by MeshPart::node
  std::vector<std::string> mtl_files = {};        // an OBJ file's material libraries, not read yet
  std::set<std::string> mtl_materials = {};       // what those that were read define

  // Every triangle from here on belongs to a part of this name.
  void begin_part(std::string name);
  // Counts the last part's triangles, and removes parts that have none.
  void end_parts();

  // Appends a polygon's triangles as triangulate_polygon does. normals: the authored ones of its corners, in their order; empty when there
  // are none. appearance: null where there is none. False, and nothing appended, when it has too many corners.
  bool add_polygon(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> normals,
                   const PolygonAppearance* appearance = nullptr);
  // The same for one triangle.
  void add_triangle(const Triangle& triangle, const std::array<Eigen::Vector3f, 3>& normals);
  // Call once at the end: triangles without normals get zero ones if others have some.
  void end_normals();
  // Call once at the end: triangles without an appearance get an empty one if others have one. The same for their haptics.
  void complete_appearance();
};

// One strict reader a format; bytes is the whole file. max_triangles: with more the file is rejected, before memory is taken for them: a
// triangle of a polygon takes many times the bytes of its corner. Errors say where in the file, not which file. RT: set-up only.
Result<RawMesh> read_obj(std::string_view bytes, AppearanceReading appearance = AppearanceReading::off,
                         std::size_t max_triangles = kMaxMeshTriangles);
Result<RawMesh> read_stl(std::string_view bytes);
Result<RawMesh> read_ply(std::string_view bytes, const std::filesystem::path& folder = {},
                         AppearanceReading appearance = AppearanceReading::off, std::size_t max_triangles = kMaxMeshTriangles);
// folder: where buffers with relative addresses are. max_triangles: of all instances together; with more the file is rejected.
Result<RawMesh> read_gltf(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles = kMaxMeshTriangles,
                          AppearanceReading appearance = AppearanceReading::off);
Result<RawMesh> read_glb(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles = kMaxMeshTriangles,
                         AppearanceReading appearance = AppearanceReading::off);

}  // namespace hapton
