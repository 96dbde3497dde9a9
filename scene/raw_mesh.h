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

// Appearance of a polygon: its material and its corners, in the order of the polygon.
struct PolygonAppearance {
  std::uint32_t material = TriangleAppearance::kNoMaterial;
  bool has_colours = false;
  std::span<const CornerAppearance> corners;
};

// What a reader found in a file, before welding, in the file's own units. Every index is in range, every coordinate finite.
struct RawMesh {
  std::string format;
  TriangleMesh mesh;
  std::vector<MeshPart> parts;
  std::vector<std::string> notes;
  MeshAppearance appearance = {};                 // without triangles if it was not requested or the file has none
  MeshHaptics haptics = {};                       // glTF files only
  std::vector<MeshAnimation> animations = {};     // glTF files only
  std::map<std::size_t, MeshMorphs> morphs = {};  // glTF files only; key: MeshPart::node
  std::vector<std::string> mtl_files = {};        // OBJ files only: names of the material libraries, which are not read yet
  std::set<std::string> mtl_materials = {};       // names of the materials in the libraries that were read

  // Begins a part with this name: every triangle that is appended after this call belongs to it.
  void begin_part(std::string name);
  // Counts the triangles of the last part, and removes that part if it has none.
  void end_parts();

  // Appends a polygon's triangles as triangulate_polygon does. normals: those of the file for its corners, in their order; empty: none.
  // appearance: null: none. False, and nothing appended, if the polygon has too many corners and is not convex.
  bool add_polygon(std::span<const std::uint32_t> corners, std::span<const Eigen::Vector3f> normals,
                   const PolygonAppearance* appearance = nullptr);
  // Appends one triangle with the normals of its corners.
  void add_triangle(const Triangle& triangle, const std::array<Eigen::Vector3f, 3>& normals);
  // Call once at the end: if some triangles have normals, those without get zero ones.
  void end_normals();
  // Call once at the end: if some triangles have an appearance, those without get an empty one. The same for the haptics.
  void complete_appearance();
};

// One strict reader for each format; bytes is the whole file. max_triangles: a file with more is rejected before they take memory, since a
// triangle of a polygon takes many times the bytes of its corner. Errors name the place in the file, not the file. RT: set-up only.
Result<RawMesh> read_obj(std::string_view bytes, AppearanceReading appearance = AppearanceReading::off,
                         std::size_t max_triangles = kMaxMeshTriangles);
Result<RawMesh> read_stl(std::string_view bytes);
Result<RawMesh> read_ply(std::string_view bytes, const std::filesystem::path& folder = {},
                         AppearanceReading appearance = AppearanceReading::off, std::size_t max_triangles = kMaxMeshTriangles);
// folder: where buffers with relative addresses are. max_triangles: of all instances together; a file with more is rejected.
Result<RawMesh> read_gltf(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles = kMaxMeshTriangles,
                          AppearanceReading appearance = AppearanceReading::off);
Result<RawMesh> read_glb(std::string_view bytes, const std::filesystem::path& folder, std::size_t max_triangles = kMaxMeshTriangles,
                         AppearanceReading appearance = AppearanceReading::off);

}  // namespace hapton
