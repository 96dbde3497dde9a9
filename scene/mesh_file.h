#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "scene/mesh_animation.h"
#include "scene/mesh_appearance.h"
#include "scene/mesh_haptics.h"
#include "scene/unit.h"

namespace hapton {

// A named range of consecutive triangles: an OBJ object or group, an STL solid, a glTF node.
struct MeshPart {
  std::string name;
  std::size_t first_triangle = 0;
  std::size_t triangle_count = 0;
  std::string object = {};  // OBJ group: the object that contains it; otherwise empty
  std::size_t node = 0;     // glTF: index of the node in the file
};

// The content of a mesh file.
struct MeshFile {
  TriangleMesh mesh;                              // metres, the file's own frame; node transforms applied
  std::vector<MeshPart> parts;                    // in the order of the file; each triangle is in one part. Names may repeat or be empty
  std::string format;                             // "OBJ", "ASCII STL", "binary PLY" ...
  Unit unit = Unit::m;                            // the unit that the numbers in the file were read in
  std::size_t file_vertices = 0;                  // before vertices are welded and unused ones dropped; those of each instance count
  std::vector<std::string> notes;                 // what was skipped or is suspicious, one line each; not errors
  MeshAppearance appearance;                      // without triangles if it was not requested or the file has none
  MeshHaptics haptics = {};                       // glTF: MPEG_haptic_material
  std::vector<MeshAnimation> animations = {};     // glTF
  std::map<std::size_t, MeshMorphs> morphs = {};  // glTF; key: MeshPart::node
};

// The largest file that is read, whatever its header says: it takes about 4 GB in memory.
constexpr std::size_t kMaxMeshTriangles = std::size_t{1} << 26;
constexpr std::size_t kMaxMeshFileBytes = std::size_t{1} << 31;

// Reads OBJ, STL (ASCII, binary), PLY (ASCII, binary of either byte order), glTF and GLB; the file name's extension decides. Polygons are
// triangulated, vertices with equal coordinates are welded, unused vertices dropped; triangles keep the file's order and winding,
// degenerate ones stay. Positions are scaled to metres. unit: the unit of the file's numbers; none: metres. glTF is in metres by its
// standard; any other unit is rejected. Post: every coordinate is finite, every index in range, at least one triangle. appearance:
// whether colours and textures are read as well. A missing texture is a note, but an error if forces need it. Error: one line with the
// file, the place in it (line, vertex, byte) and what to do. RT: set-up only. Memory is bounded by the file's size, never by what its
// header claims.
Result<MeshFile> load_mesh_file(const std::filesystem::path& path, std::optional<Unit> unit = std::nullopt,
                                AppearanceReading appearance = AppearanceReading::off);

// Whether load_mesh_file reads files with this name's extension.
bool is_mesh_file_name(const std::filesystem::path& path);

// "object/name"; only the name if the part has no object.
std::string full_name(const MeshPart& part);
// Whether the name refers to the part: its own name, its full name, or the name of its object.
bool is_named(const MeshPart& part, const std::string& name);

// The triangles of every part that the name refers to (is_named), with the vertices they use. Error: no such part; lists the parts.
// appearance, haptics: if not null, receives the visual and the haptic maps of those triangles.
Result<TriangleMesh> extract_part(const MeshFile& file, const std::string& name, MeshAppearance* appearance = nullptr,
                                  MeshAppearance* haptics = nullptr);
// The triangles of all parts of these nodes, likewise. Pre: at least one of the nodes has triangles.
TriangleMesh extract_nodes(const MeshFile& file, const std::vector<std::size_t>& nodes, MeshAppearance* appearance = nullptr,
                           MeshAppearance* haptics = nullptr);

}  // namespace hapton
