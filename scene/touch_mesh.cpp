#include "scene/touch_mesh.h"

#include <utility>

#include "scene/mesh_file.h"
#include "scene/scene_hash.h"

namespace hapton {

SealReport seal_for_touch(TriangleMesh& mesh, CrackSealing sealing) {
  SealReport report;
  if (sealing == CrackSealing::on) mesh = seal_cracks(std::move(mesh), report);
  return report;
}

Result<TouchMesh> load_touch_mesh(const std::filesystem::path& path, std::optional<Unit> unit, CrackSealing sealing,
                                  AppearanceReading appearance) {
  Result<MeshFile> file = load_mesh_file(path, unit, appearance);
  if (!file) return tl::unexpected(file.error());
  TouchMesh touch{.mesh = std::move(file->mesh),
                  .sealed = {},
                  .given_hash = 0,
                  .notes = std::move(file->notes),
                  .has_haptics = file->haptics.any(),
                  .appearance = std::move(file->appearance)};
  touch.given_hash = hash_mesh(touch.mesh);
  for (const Vec3& vertex : touch.mesh.vertices) touch.box.extend(vertex);
  touch.sealed = seal_for_touch(touch.mesh, sealing);
  if (touch.sealed.has_sealed()) touch.appearance = {};
  if (touch.sealed.is_worth_a_note()) touch.notes.push_back(touch.sealed.describe());
  return touch;
}

}  // namespace hapton
