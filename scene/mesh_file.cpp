#include "scene/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>
#include <string_view>

#include "scene/file_bytes.h"
#include "scene/raw_mesh.h"
#include "scene/read_mtl.h"
#include "scene/text_cursor.h"
#include "scene/weld.h"

namespace hapton {
namespace {

// Beyond this squared lengths and volumes would overflow or lose all meaning.
constexpr double kMaxCoordinateM = 1e12;

std::string extension_of(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

bool is_gltf(const std::string& extension) { return extension == ".gltf" || extension == ".glb"; }

// The libraries that an OBJ file names, where there are any.
RawMesh with_materials(RawMesh raw, const std::filesystem::path& folder) {
  for (const std::string& name : raw.mtl_files) {
    const Result<std::string> library = read_file_bytes(folder / name, kMaxMeshFileBytes);
    if (library) {
      read_mtl(*library, (folder / name).parent_path(), raw);
    } else {
      raw.notes.push_back(fmt::format("a material library is missing: '{}' cannot be read", printable(name)));
    }
  }
  return raw;
}

Result<RawMesh> read_raw(std::string_view bytes, const std::string& extension, const std::filesystem::path& folder, LookReading look) {
  if (extension == ".obj") return read_obj(bytes, look).map([&](RawMesh&& raw) { return with_materials(std::move(raw), folder); });
  if (extension == ".stl") return read_stl(bytes);
  if (extension == ".ply") return read_ply(bytes, folder, look);
  return extension == ".glb" ? read_glb(bytes, folder, kMaxMeshTriangles, look) : read_gltf(bytes, folder, kMaxMeshTriangles, look);
}

Result<MeshFile> to_metres(RawMesh raw, Unit unit, bool unit_is_known) {
  if (raw.mesh.triangles.empty()) return fail("holds no triangles: export the surface as triangles");
  if (raw.mesh.triangles.size() > kMaxMeshTriangles) {
    return fail("has {} triangles, more than {}: simplify it", raw.mesh.triangles.size(), kMaxMeshTriangles);
  }
  raw.end_normals();
  raw.end_look();
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
  if (raw.look.says_anything() || raw.look.has_texcoords()) file.look = std::move(raw.look);
  const double longest = (highest - lowest).maxCoeff();
  if (!unit_is_known && (longest > 10.0 || longest < 1e-3)) {
    file.notes.push_back(fmt::format("is {:.4g} m long read in {}: if that is wrong, give its unit", longest, name_of(unit)));
  }
  return file;
}

}  // namespace

bool is_mesh_file_name(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  return extension == ".obj" || extension == ".stl" || extension == ".ply" || is_gltf(extension);
}

Result<MeshFile> load_mesh_file(const std::filesystem::path& path, std::optional<Unit> unit, LookReading look) {
  const std::string extension = extension_of(path);
  const Result<std::string> bytes = read_file_bytes(path, kMaxMeshFileBytes);
  if (!bytes) return tl::unexpected(bytes.error());
  if (!is_mesh_file_name(path)) {
    return fail("{}: unknown mesh extension '{}': convert it to .obj, .stl, .ply, .gltf or .glb", path.string(), extension);
  }
  if (is_gltf(extension) && unit.value_or(Unit::m) != Unit::m) {
    return fail("{}: glTF is always in metres, not {}: leave the unit out", path.string(), name_of(*unit));
  }
  Result<MeshFile> file = read_raw(*bytes, extension, path.parent_path(), look).and_then([&](RawMesh&& raw) {
    return to_metres(std::move(raw), unit.value_or(Unit::m), unit.has_value() || is_gltf(extension));
  });
  if (!file) return fail("{}: {}", path.string(), file.error().what);
  return file;
}

std::string full_name(const MeshPart& part) { return part.object.empty() ? part.name : part.object + "/" + part.name; }

Result<TriangleMesh> extract_part(const MeshFile& file, const std::string& name, MeshLook* look) {
  TriangleMesh part;
  std::string names;
  const bool has_look = look != nullptr && !file.look.triangles.empty();
  if (has_look) *look = {.images = file.look.images, .materials = file.look.materials, .triangles = {}};
  for (const MeshPart& run : file.parts) {
    const std::string full = full_name(run);
    if (name == run.name || name == full || (!name.empty() && name == run.object)) {
      const auto first = file.mesh.triangles.begin() + static_cast<std::ptrdiff_t>(run.first_triangle);
      part.triangles.insert(part.triangles.end(), first, first + static_cast<std::ptrdiff_t>(run.triangle_count));
      if (has_look) {
        const auto from = file.look.triangles.begin() + static_cast<std::ptrdiff_t>(run.first_triangle);
        look->triangles.insert(look->triangles.end(), from, from + static_cast<std::ptrdiff_t>(run.triangle_count));
      }
      if (file.mesh.has_authored_normals()) {
        const auto from = file.mesh.authored_normals.begin() + static_cast<std::ptrdiff_t>(run.first_triangle);
        part.authored_normals.insert(part.authored_normals.end(), from, from + static_cast<std::ptrdiff_t>(run.triangle_count));
      }
    }
    if (names.size() < 200) names += (names.empty() ? "'" : ", '") + full + "'";
  }
  if (part.triangles.empty()) return fail("has no part '{}': it has {}", name, names);
  part.vertices = file.mesh.vertices;
  drop_unused_vertices(part);
  return part;
}

}  // namespace hapton
