// Any bytes as the Draco data of a glTF primitive.
#include "scene/gltf/draco.h"
#include "tests/fuzz/mesh_target.h"

FUZZ_TARGET(draco) {
  const auto mesh =
      hapton::gltf::decode_draco(hapton::fuzz::text_of(bytes),
                                 {.position = 0, .normal = 1, .max_triangles = hapton::fuzz::kMaxTriangles, .others = {0, 1, 2}}, "here");
  if (!mesh) {
    hapton::fuzz::require(!mesh.error().what.empty() && mesh.error().what.find('\n') == std::string::npos);
    return;
  }
  hapton::fuzz::note_passage();
  hapton::fuzz::require(mesh->corners.size() <= 3 * hapton::fuzz::kMaxTriangles && mesh->corners.size() % 3 == 0);
  hapton::fuzz::require(mesh->normals.empty() || mesh->normals.size() == mesh->positions.size());
  hapton::fuzz::require(mesh->others.size() == 3);
  for (const auto& values : mesh->others) hapton::fuzz::require(values.bytes.size() % mesh->positions.size() == 0);
  for (const std::uint32_t corner : mesh->corners) hapton::fuzz::require(corner < mesh->positions.size());
}
