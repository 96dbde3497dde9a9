#include "haptics_node/placed_scene.h"

#include <memory>
#include <string>

#include "runtime/log.h"
#include "scene/annotations_file.h"

namespace hapton {

TriangleMesh move_mesh(const Pose& X, const TriangleMesh& mesh) {
  TriangleMesh moved = mesh;
  for (Vec3& vertex : moved.vertices) vertex = X * vertex;
  const Eigen::Matrix3f turn = X.linear().cast<float>();
  for (auto& corners : moved.authored_normals) {
    for (Eigen::Vector3f& normal : corners) normal = turn * normal;
  }
  return moved;
}

Result<std::vector<PutDown>> read_put_down(const std::filesystem::path& file, const Scene& scene) {
  std::vector<PutDown> put_down;
  if (file.empty() || !std::filesystem::exists(file)) return put_down;
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) names.push_back(object.name);
  auto read = read_annotations(file, names, scene.given_hash);
  if (!read) return tl::unexpected(read.error());
  if (const std::string misfit = read->describe_misfit(); !misfit.empty()) log_warning("{}: {}", file.string(), misfit);
  for (const PutDown& each : read->annotations.put_down) {
    const auto number = static_cast<std::size_t>(each.object);
    if (number >= scene.objects.size()) continue;
    if (!scene.objects[number].is_movable) {
      log_warning("{}: {} is not movable in this scene, and stays where it is", file.string(), scene.objects[number].name);
      continue;
    }
    log_info("{} is placed as {} says", scene.objects[number].name, file.string());
    put_down.push_back(each);
  }
  return put_down;
}

Scene place_objects(const Scene& scene, const std::vector<PutDown>& put_down) {
  Scene placed = scene;
  for (const PutDown& each : put_down) {
    const auto number = static_cast<std::size_t>(each.object);
    // Of the scene as it was loaded: a file may name an object twice.
    placed.objects[number].mesh = std::make_shared<const TriangleMesh>(move_mesh(each.pose(), *scene.objects[number].mesh));
  }
  return placed;
}

}  // namespace hapton
