#include "haptics_node/placed_scene.h"

#include <memory>
#include <set>
#include <string>
#include <utility>

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

void move_object(const Pose& X, const SceneObject& as_loaded, SceneObject& object) {
  object.mesh = std::make_shared<const TriangleMesh>(move_mesh(X, *as_loaded.mesh));
  if (as_loaded.effects.maps.triangles == nullptr) return;
  auto mapped = std::make_shared<std::vector<MappedTriangle>>(*as_loaded.effects.maps.triangles);
  for (MappedTriangle& triangle : *mapped) {
    for (Vec3& corner : triangle.corner) corner = X * corner;
  }
  object.effects.maps.triangles = std::move(mapped);
}

namespace {

// Empty if the file does not exist yet.
Result<AnnotationsRead> read_saved(const std::filesystem::path& file, const Scene& scene) {
  if (file.empty() || !std::filesystem::exists(file)) return AnnotationsRead();
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) names.push_back(object.name);
  return read_annotations(file, names, scene.given_hash);
}

}  // namespace

Result<std::vector<PutDown>> read_saved_poses(const std::filesystem::path& file, const Scene& scene) {
  std::vector<PutDown> put_down;
  auto read = read_saved(file, scene);
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

Result<std::vector<CarvedPress>> read_saved_carves(const std::filesystem::path& file, const Scene& scene) {
  auto read = read_saved(file, scene);
  if (!read) return tl::unexpected(read.error());
  std::vector<CarvedPress> carved;
  std::set<std::int32_t> left_out;
  for (CarvedPress& press : read->annotations.carved) {
    const auto number = static_cast<std::size_t>(press.object);
    if (number >= scene.objects.size()) continue;
    if (scene.objects[number].sculpt) {
      carved.push_back(std::move(press));
    } else if (left_out.insert(press.object).second) {
      log_warning("{}: {} cannot be carved in this scene, and stays whole; give it 'sculpt = true' in the scene file", file.string(),
                  scene.objects[number].name);
    }
  }
  return carved;
}

std::vector<MadeCarve> apply_saved_carves(const std::vector<CarvedPress>& carved, HapticsStep& step) {
  std::vector<MadeCarve> made;
  for (const CarvedPress& press : carved) {
    bool begins = true;
    for (const Carve& carve : press.carves) {
      if (!step.repeat_carve(press.object, carve)) continue;
      made.push_back({.object = press.object, .serial = step.touch().newest_carve_serial(), .carve = rounded(carve), .begins = begins});
      begins = false;
    }
  }
  return made;
}

Scene place_objects(const Scene& scene, const std::vector<PutDown>& put_down) {
  Scene placed = scene;
  for (const PutDown& each : put_down) {
    const auto number = static_cast<std::size_t>(each.object);
    // Moves the object from its place in the scene file, because the annotations may name an object twice.
    move_object(each.pose(), scene.objects[number], placed.objects[number]);
  }
  return placed;
}

}  // namespace hapton
