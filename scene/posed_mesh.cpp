#include "scene/posed_mesh.h"

#include "scene/scene_hash.h"

namespace hapton {

Result<PosedMesh> make_posed_mesh(const ObjectSpec& object, const std::filesystem::path& folder, MeshCache& cache,
                                  std::vector<std::string>& notes) {
  const std::filesystem::path path = (folder / object.mesh).lexically_normal();
  const Result<const MeshCache::ReadyMesh*> loaded = cache.load(path, object, notes);
  if (!loaded) return tl::unexpected(loaded.error());
  const auto pose = [&](const Vec3& vertex) { return Vec3(object.p_SM + object.q_SM * (object.scale * vertex)); };
  PosedMesh posed{.mesh = (*loaded)->mesh, .sealed = (*loaded)->sealed, .box = {}, .given_hash = 0, .appearance = (*loaded)->appearance};
  if (object.has_colour) posed.appearance.reset();
  if (object.animated_morphs != nullptr) posed.in_file = posed.mesh.vertices;
  posed.given_hash = hash_placed((*loaded)->given_hash, object.scale, object.q_SM, object.p_SM);
  for (const Vec3& vertex : posed.sealed.has_sealed() ? (*loaded)->unsealed_vertices : posed.mesh.vertices) posed.box.extend(pose(vertex));
  for (Vec3& vertex : posed.mesh.vertices) vertex = pose(vertex);
  if (!object.morphs.empty()) {
    for (const Vec3& vertex : (*loaded)->unsealed_vertices) posed.unsealed_vertices.push_back(pose(vertex));
  }
  posed.map = (*loaded)->map;
  if (posed.map.mesh != nullptr) {
    for (const Vec3& vertex : posed.map.mesh->vertices) posed.map.vertices.push_back(pose(vertex));
  }
  const Eigen::Quaternionf turn = object.q_SM.cast<float>();
  for (auto& normals : posed.mesh.authored_normals) normals = {turn * normals[0], turn * normals[1], turn * normals[2]};
  scale_widths(posed.sealed, object.scale);
  return posed;
}

void apply_fit(const SceneFit& fit, std::vector<PosedMesh>& meshes) {
  for (PosedMesh& posed : meshes) {
    fit.apply(posed.mesh, posed.sealed);
    for (Vec3& vertex : posed.map.vertices) vertex = fit.apply(vertex);
    for (Vec3& vertex : posed.unsealed_vertices) vertex = fit.apply(vertex);
  }
}

}  // namespace hapton
