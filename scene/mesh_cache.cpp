#include "scene/mesh_cache.h"

#include <algorithm>
#include "scene/scene_hash.h"
#include "scene/text_cursor.h"

namespace hapton {
namespace {

// The part of the file that the object names. appearance: its colours and images; maps: its images for forces.
Result<TriangleMesh> cut(const MeshFile& file, const std::filesystem::path& path, const ObjectSpec& object, MeshAppearance& appearance,
                         MeshAppearance& maps) {
  if (!object.nodes.empty()) return extract_nodes(file, object.nodes, &appearance, &maps);
  if (object.part.empty()) {
    appearance = file.appearance;
    maps = file.haptics.maps;
    return file.mesh;
  }
  auto mesh = extract_part(file, object.part, &appearance, &maps);
  if (!mesh) return fail("line {}: {}: {}", object.part_line, path.string(), mesh.error().what);
  return mesh;
}

}  // namespace

Result<const MeshCache::ReadyMesh*> MeshCache::load(const std::filesystem::path& path, const ObjectSpec& object,
                                                    std::vector<std::string>& notes) {
  const CrackSealing sealing = object.seal_cracks ? sealing_ : CrackSealing::off;
  const Key key(path.string(), object.unit, object.part, object.nodes, sealing, object.haptic_material);
  if (const auto found = meshes_.find(key); found != meshes_.end()) return &found->second;
  const Result<const MeshFile*> file = load_file(path, object, notes);
  if (!file) return tl::unexpected(file.error());
  MeshAppearance appearance;
  MeshAppearance maps;
  Result<TriangleMesh> mesh = cut(**file, path, object, appearance, maps);
  if (!mesh) return tl::unexpected(mesh.error());
  if (object.haptic_material) keep_haptic_material(*object.haptic_material, *mesh, appearance, maps);
  appearance.drop_unused_images();  // each part of a file lists the images of all its parts
  ReadyMesh ready;
  std::vector<Vec3> vertices = mesh->vertices;
  ready.given_hash = hash_mesh(*mesh);
  if (maps_ != AppearanceReading::off || object.haptic_material) {
    for (TextureImage& image : maps.images) image.bytes = {};  // the materials contain them
    ready.map = {{},
                 std::make_shared<const TriangleMesh>(*mesh),
                 std::make_shared<const MeshAppearance>(object.haptic_material ? std::move(maps) : appearance)};
  }
  ready.sealed = seal_for_touch(*mesh, sealing);
  ready.mesh = std::move(*mesh);
  if (ready.sealed.has_sealed()) ready.unsealed_vertices = std::move(vertices);
  if (appearance_ == AppearanceReading::on && !ready.sealed.has_sealed() && appearance.has_colours_or_images())
    ready.appearance = std::make_shared<const MeshAppearance>(std::move(appearance));
  if (ready.sealed.is_worth_a_note()) {
    notes.push_back(
        fmt::format("{}{}: {}", path.string(), object.part.empty() ? "" : " " + printable(object.part), ready.sealed.describe()));
  }
  return &meshes_.emplace(key, std::move(ready)).first->second;
}

Result<void> MeshCache::count(const std::filesystem::path& folder, const ObjectSpec& object, std::vector<std::string>& notes) {
  const auto ready = load((folder / object.mesh).lexically_normal(), object, notes);
  if (!ready) return tl::unexpected(ready.error());
  object_triangles_ += (*ready)->mesh.triangles.size();
  if (object_triangles_ <= kMaxMeshTriangles) return {};
  return fail(
      "line {}: with '{}' the objects have more than {} triangles together: use fewer objects or instances, or simplify their meshes",
      object.mesh_line, printable(name_of(object)), kMaxMeshTriangles);
}

Result<const MaterialSpec*> MeshCache::find_material(const std::filesystem::path& path, const MeshHaptics& haptics, std::uint32_t index) {
  const auto key = std::make_pair(&haptics, index);
  if (const auto found = materials_.find(key); found != materials_.end()) return &found->second;
  Result<MaterialSpec> material = read_material(haptics.materials[index], haptics.maps, path.string());
  if (!material) return tl::unexpected(material.error());
  return &materials_.emplace(key, std::move(*material)).first->second;
}

Result<MeshCache::HapticChoice> MeshCache::find_haptics(const std::filesystem::path& path, const ObjectSpec& object,
                                                        std::vector<std::string>& notes) {
  const Result<const MeshFile*> file = load_file(path, object, notes);
  if (!file) return tl::unexpected(file.error());
  if (!(*file)->haptics.any()) return HapticChoice();
  MeshAppearance appearance;
  MeshAppearance maps;
  if (const auto mesh = cut(**file, path, object, appearance, maps); !mesh) return tl::unexpected(mesh.error());
  return HapticChoice{&(*file)->haptics, list_haptic_materials(maps)};
}

Result<const MeshFile*> MeshCache::load_file(const std::filesystem::path& path, const ObjectSpec& object, std::vector<std::string>& notes) {
  const auto key = std::make_pair(path.string(), object.unit);
  if (const auto found = files_.find(key); found != files_.end()) return &found->second;
  Result<MeshFile> file = load_mesh_file(path, object.unit, std::max(maps_, appearance_));
  if (!file) return fail("line {}: {}", object.mesh_line, file.error().what);
  file_triangles_ += file->mesh.triangles.size();
  if (file_triangles_ > kMaxMeshTriangles) {
    return fail("line {}: with {} the mesh files have more than {} triangles together: simplify them", object.mesh_line, path.string(),
                kMaxMeshTriangles);
  }
  for (const std::string& note : file->notes) notes.push_back(fmt::format("{}: {}", path.string(), note));
  return &files_.emplace(key, std::move(*file)).first->second;
}

}  // namespace hapton
