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
  std::string object = {};  // of an OBJ group: the object that it lies in
  std::size_t node = 0;     // of glTF: its number in the file
};

// What a mesh file holds.
struct MeshFile {
  TriangleMesh mesh;                              // metres, the file's own frame; node transforms applied
  std::vector<MeshPart> parts;                    // in order; together they hold every triangle once. Names may repeat or be empty
  std::string format;                             // "OBJ", "ASCII STL", "binary PLY" ...
  Unit unit = Unit::m;                            // the unit that the numbers in the file were read in
  std::size_t file_vertices = 0;                  // before welding and dropping unused ones; each instance counts
  std::vector<std::string> notes;                 // what was skipped or is suspicious, one line each; not errors
  MeshAppearance appearance;                      // with no triangles if it was not requested or the file has none
  MeshHaptics haptics = {};                       // of glTF: MPEG_haptic_material
  std::vector<MeshAnimation> animations = {};     // of glTF
  std::map<std::size_t, MeshMorphs> morphs = {};  // of glTF, by MeshPart::node
};

// No file we read may hold more, whatever its header says: about 4 GB once loaded.
constexpr std::size_t kMaxMeshTriangles = std::size_t{1} << 26;
constexpr std::size_t kMaxMeshFileBytes = std::size_t{1} << 31;

// Reads OBJ, STL (ASCII, binary), PLY (ASCII, binary of either byte order), glTF and GLB; the extension decides.
// Polygons are triangulated, vertices equal to the bit are welded, unused ones dropped; triangles keep the file's
// order and winding, degenerate ones stay. Positions are scaled to metres. unit: what the file's numbers are in;
// none given means metres. glTF is in metres by its standard, any other unit is rejected. Post: every coordinate is
// finite, every index in range, at least one triangle. appearance: whether colours and textures are read as well; a
// texture that cannot be found is a note, not an error; a missing texture that forces use is an error. Error: one line with the file, the
// place in it (line, vertex, byte) and what to do. RT: set-up only. Memory is bounded by the file's size, never by what its header claims.
Result<MeshFile> load_mesh_file(const std::filesystem::path& path, std::optional<Unit> unit = std::nullopt,
                                AppearanceReading appearance = AppearanceReading::off);

// True for the extensions load_mesh_file knows.
bool is_mesh_file_name(const std::filesystem::path& path);

// "object/name", or the one of the two that is not empty.
std::string full_name(const MeshPart& part);
// Whether the name refers to the part: its own name, its full name, or the name of its object.
bool is_named(const MeshPart& part, const std::string& name);

// The triangles of every part that the name refers to (is_named), with the vertices they use. Error: no such part; lists the parts.
// appearance, haptics: if not null, receives the visual and the haptic maps of those triangles.
Result<TriangleMesh> extract_part(const MeshFile& file, const std::string& name, MeshAppearance* appearance = nullptr,
                                  MeshAppearance* haptics = nullptr);
// The same of the parts of these nodes. Pre: one of them has triangles.
TriangleMesh extract_nodes(const MeshFile& file, const std::vector<std::size_t>& nodes, MeshAppearance* appearance = nullptr,
                           MeshAppearance* haptics = nullptr);

}  // namespace hapton
