#include "vision_node/moved_objects.h"

namespace hapton {
namespace {

bool is_same(const ObjectPose& a, const ObjectPose& b) { return a.is_held == b.is_held && a.p_m == b.p_m && a.q.coeffs() == b.q.coeffs(); }

Pose pose_of(const ObjectPose& pose) {
  Pose X = Pose::Identity();
  X.translation() = pose.p_m;
  X.linear() = pose.q.normalized().toRotationMatrix();
  return X;
}

SceneTool tool_of(const SceneObject& object, const Pose& X_TO) {
  TriangleMesh mesh = *object.mesh;
  for (Vec3& vertex : mesh.vertices) vertex = X_TO * vertex;
  return {.name = object.name, .mesh = std::make_shared<const TriangleMesh>(std::move(mesh)), .colour = object.colour};
}

}  // namespace

MovedObjects::MovedObjects(StereoView& view, const Scene& scene)
    : view_(view), scene_(scene), known_(scene.objects.size()), X_SO_(scene.objects.size(), Pose::Identity()) {
  for (const SceneObject& object : scene.objects) has_motion_ = has_motion_ || object.motion != nullptr;
  set_time(0);
  place_moving();
}

bool MovedObjects::set_time(std::int64_t scene_time_ns) {
  bool has_moved = false;
  for (std::size_t o = 0; o < X_SO_.size(); ++o) {
    if (scene_.objects[o].motion == nullptr) continue;
    const Pose X_SO = scene_.objects[o].motion->pose_at(1e-9 * static_cast<double>(scene_time_ns));
    has_moved = has_moved || X_SO.matrix() != X_SO_[o].matrix();
    X_SO_[o] = X_SO;
  }
  return has_moved;
}

void MovedObjects::place_moving() {
  for (std::size_t o = 0; o < X_SO_.size(); ++o) {
    if (scene_.objects[o].motion != nullptr) view_.place_object(o, X_SO_[o], true);
  }
}

std::int32_t MovedObjects::held() const {
  for (std::size_t o = 0; o < known_.size(); ++o) {
    if (known_[o].is_held) return static_cast<std::int32_t>(o);
  }
  return -1;
}

bool MovedObjects::take(const ObjectPose& pose) {
  if (pose.object < 0 || static_cast<std::size_t>(pose.object) >= known_.size()) return false;
  const auto number = static_cast<std::size_t>(pose.object);
  if (scene_.objects[number].motion != nullptr) return false;
  ObjectPose& known = known_[number];
  if (is_same(known, pose)) return false;
  const bool was_held = known.is_held;
  known = pose;
  if (pose.is_held) {
    view_.set_tool(tool_of(scene_.objects[number], pose_of(pose)), true);
  } else if (was_held) {
    view_.clear_tool();
  }
  view_.place_object(number, pose.is_held ? Pose::Identity() : pose_of(pose), !pose.is_held);
  return true;
}

}  // namespace hapton
