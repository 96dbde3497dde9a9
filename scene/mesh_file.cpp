#include "scene/mesh_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <functional>
#include <set>
#include <string_view>

#include "scene/file_bytes.h"
#include "scene/raw_mesh.h"
#include "scene/read_mtl.h"
#include "scene/text_cursor.h"
#include "scene/weld.h"

namespace hapton {
namespace {

// Largest coordinate that is accepted: squares, volumes and their sums stay far from overflow.
constexpr double kMaxCoordinateM = 1e12;

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_gltf(const std::string& extension) { return extension == ".gltf" || extension == ".glb"; }

// Adds a note about materials that faces name, but that no library contains.
void note_unknown_materials(RawMesh& raw) {
  std::size_t count = 0;
  std::string first;
  for (const VisualMaterial& material : raw.appearance.materials) {
    if (raw.mtl_materials.contains(material.name)) continue;
    if (++count == 1) first = printable(material.name);
  }
  if (count == 0) return;
  raw.notes.push_back(fmt::format("material '{}'{} is in no material library that could be read: it has no colour", first,
                                  count > 1 ? fmt::format(", as {} in all,", count) : ""));
}

// The files that "mtllib" lines name. A line may name several files, or one whose name contains blanks.
std::vector<std::string> list_libraries(const std::vector<std::string>& lines, const std::filesystem::path& folder) {
  std::vector<std::string> names;
  // Some programs name the same library before each object.
  std::set<std::string, std::less<>> known;
  const auto add = [&](std::string_view name) {
    if (known.emplace(name).second) names.emplace_back(name);
  };
  const auto exists = [&](std::string_view name) {
    std::error_code ignored;
    return std::filesystem::exists(folder / name, ignored);
  };
  for (const std::string& line : lines) {
    std::vector<std::string> words;
    TextCursor cursor(line);
    for (auto word = cursor.word_in_line(); !word.empty(); word = cursor.word_in_line()) words.emplace_back(without_quotes(word));
    if (words.size() > 1 && !exists(without_quotes(line)) && std::ranges::any_of(words, exists)) {
      for (const std::string& word : words) add(word);
    } else {
      add(without_quotes(line));
    }
  }
  return names;
}

// Reads the material libraries that an OBJ file names; one that cannot be read becomes a note.
RawMesh with_materials(RawMesh raw, const std::filesystem::path& folder) {
  bool is_any_read = false;
  for (const std::string& name : list_libraries(raw.mtl_files, folder)) {
    const Result<std::string> library = read_file_bytes(folder / name, kMaxMeshFileBytes);
    is_any_read = is_any_read || library.has_value();
    if (library) {
      read_mtl(*library, (folder / name).parent_path(), raw);
    } else {
      raw.notes.push_back(fmt::format("a material library is missing: '{}' cannot be read", printable(name)));
    }
  }
  if (is_any_read) note_unknown_materials(raw);
  return raw;
}

Result<RawMesh> read_raw(std::string_view bytes, const std::string& extension, const std::filesystem::path& folder,
                         AppearanceReading appearance) {
  if (extension == ".obj") return read_obj(bytes, appearance).map([&](RawMesh&& raw) { return with_materials(std::move(raw), folder); });
  if (extension == ".stl") return read_stl(bytes);
  if (extension == ".ply") return read_ply(bytes, folder, appearance);
  return extension == ".glb" ? read_glb(bytes, folder, kMaxMeshTriangles, appearance)
                             : read_gltf(bytes, folder, kMaxMeshTriangles, appearance);
}

Result<MeshFile> to_metres(RawMesh raw, Unit unit, bool unit_is_known) {
  if (raw.mesh.triangles.empty()) return fail("holds no triangles: export the surface as triangles");
  if (raw.mesh.triangles.size() > kMaxMeshTriangles) {
    return fail("has {} triangles, more than {}: simplify it", raw.mesh.triangles.size(), kMaxMeshTriangles);
  }
  raw.end_normals();
  raw.complete_appearance();
  MeshFile file;
  file.file_vertices = raw.mesh.vertices.size();
  weld_vertices(raw.mesh);
  const double metres = metres_per(unit);
  Vec3 lowest = Vec3::Constant(HUGE_VAL);
  Vec3 highest = -lowest;
  for (Vec3& vertex : raw.mesh.vertices) {
    vertex *= metres;
    lowest = lowest.cwiseMin(vertex);
    highest = highest.cwiseMax(vertex);
  }
  if (lowest.minCoeff() < -kMaxCoordinateM || highest.maxCoeff() > kMaxCoordinateM) {
    return fail("has a coordinate beyond {:g} m: repair the mesh or give its unit", kMaxCoordinateM);
  }
  file.mesh = std::move(raw.mesh);
  file.parts = std::move(raw.parts);
  file.format = std::move(raw.format);
  file.unit = unit;
  file.notes = std::move(raw.notes);
  file.haptics = std::move(raw.haptics);
  file.animations = std::move(raw.animations);
  file.morphs = std::move(raw.morphs);
  if (raw.appearance.has_colours_or_images() || raw.appearance.has_texcoords()) file.appearance = std::move(raw.appearance);
  const double longest = (highest - lowest).maxCoeff();
  if (!unit_is_known && (longest > 10.0 || longest < 1e-3)) {
    file.notes.push_back(fmt::format("is {:.4g} m long if its unit is {}; otherwise give the unit", longest, name_of(unit)));
  }
  return file;
}

}  // namespace

bool is_mesh_file_name(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  return extension == ".obj" || extension == ".stl" || extension == ".ply" || is_gltf(extension);
}

Result<MeshFile> load_mesh_file(const std::filesystem::path& path, std::optional<Unit> unit, AppearanceReading appearance) {
  const std::string extension = extension_of(path);
  const Result<std::string> bytes = read_file_bytes(path, kMaxMeshFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  if (!is_mesh_file_name(path)) {
    return fail("{}: unknown mesh extension '{}': convert it to .obj, .stl, .ply, .gltf or .glb", path.string(), extension);
  }
  if (is_gltf(extension) && unit.value_or(Unit::m) != Unit::m) {
    return fail("{}: glTF is always in metres, not {}: leave the unit out", path.string(), name_of(*unit));
  }
  Result<MeshFile> file = read_raw(*bytes, extension, path.parent_path(), appearance).and_then([&](RawMesh&& raw) {
    return to_metres(std::move(raw), unit.value_or(Unit::m), unit.has_value() || is_gltf(extension));
  });
  if (!file) return fail("{}: {}", path.string(), file.error().what);
  return file;
}

std::string full_name(const MeshPart& part) { return part.object.empty() ? part.name : part.object + "/" + part.name; }

bool is_named(const MeshPart& part, const std::string& name) {
  return name == part.name || name == full_name(part) || (!name.empty() && name == part.object);
}

namespace {

// Appends the elements of a part's triangles; `from` has one for each triangle of the file.
template <class Each>
void append_run(const std::vector<Each>& from, const MeshPart& part, std::vector<Each>& to) {
  const auto first = from.begin() + static_cast<std::ptrdiff_t>(part.first_triangle);
  to.insert(to.end(), first, first + static_cast<std::ptrdiff_t>(part.triangle_count));
}

template <class Wanted>
TriangleMesh extract_if(const MeshFile& file, MeshAppearance* appearance, MeshAppearance* haptics, const Wanted& wanted) {
  TriangleMesh mesh;
  struct Look {
    const MeshAppearance& from;
    MeshAppearance* into;
  };
  const std::array<Look, 2> appearances = {Look{file.appearance, appearance}, Look{file.haptics.maps, haptics}};
  for (const auto& [from, into] : appearances) {
    if (into != nullptr && !from.triangles.empty()) *into = {.images = from.images, .materials = from.materials, .triangles = {}};
  }
  for (const MeshPart& part : file.parts) {
    if (!wanted(part)) continue;
    append_run(file.mesh.triangles, part, mesh.triangles);
    for (const auto& [from, into] : appearances) {
      if (into != nullptr && !from.triangles.empty()) append_run(from.triangles, part, into->triangles);
    }
    if (file.mesh.has_authored_normals()) append_run(file.mesh.authored_normals, part, mesh.authored_normals);
  }
  if (mesh.triangles.empty()) return mesh;
  mesh.vertices = file.mesh.vertices;
  drop_unused_vertices(mesh);
  return mesh;
}

}  // namespace

Result<TriangleMesh> extract_part(const MeshFile& file, const std::string& name, MeshAppearance* appearance, MeshAppearance* haptics) {
  TriangleMesh mesh = extract_if(file, appearance, haptics, [&](const MeshPart& part) { return is_named(part, name); });
  if (!mesh.triangles.empty()) return mesh;
  std::string names;
  for (const MeshPart& part : file.parts) {
    if (full_name(part).empty()) continue;
    if (names.size() < 200) names += (names.empty() ? "'" : ", '") + printable(full_name(part), kLongestShownName) + "'";
  }
  if (names.empty()) return fail("has no part '{}': none of its parts has a name; leave 'part' out", printable(name, kLongestShownName));
  return fail("has no part '{}': it has {}", printable(name, kLongestShownName), names);
}

TriangleMesh extract_nodes(const MeshFile& file, const std::vector<std::size_t>& nodes, MeshAppearance* appearance,
                           MeshAppearance* haptics) {
  return extract_if(file, appearance, haptics,
                    [&](const MeshPart& part) { return std::find(nodes.begin(), nodes.end(), part.node) != nodes.end(); });
}

}  // namespace hapton
