#include "vision_node/moved_objects.h"

#include <algorithm>
#include <utility>

#include "link/commanded_move.h"

namespace hapton {
namespace {

bool is_same(const ObjectPose& a, const ObjectPose& b) { return a.is_held == b.is_held && a.p_m == b.p_m && a.q.coeffs() == b.q.coeffs(); }

Pose matrix_of(const ObjectPose& pose) {
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

std::vector<std::uint32_t> count_shaped_vertices(const Scene& scene) {
  std::vector<std::uint32_t> totals;
  for (const SceneObject& object : scene.objects) {
    totals.push_back(object.program_shape != nullptr ? static_cast<std::uint32_t>(object.mesh->vertices.size()) : 0U);
  }
  return totals;
}

}  // namespace

MovedObjects::MovedObjects(StereoView& view, const Scene& scene)
    : view_(view),
      scene_(scene),
      known_poses_(scene.objects.size()),
      commanded_motions_(scene.objects.size()),
      X_SO_(scene.objects.size(), Pose::Identity()),
      weights_(scene.objects.size()),
      drawn_weights_(scene.objects.size()),
      shapes_(count_shaped_vertices(scene)),
      shape_places_(scene.objects.size()),
      drawn_shape_places_(scene.objects.size()) {
  for (const SceneObject& object : scene.objects) has_motion_ = has_motion_ || object.moves();
  forget_moves();
  set_time(0);
  place_moving();
}

void MovedObjects::forget_moves() {
  for (std::size_t o = 0; o < commanded_motions_.size(); ++o) {
    if (const auto& commanded = scene_.objects[o].commanded) commanded_motions_[o].emplace(commanded->pivot());
  }
}

bool MovedObjects::take(const ObjectMove& move, Arrival arrival) {
  const auto number = static_cast<std::size_t>(move.object);
  if (number >= commanded_motions_.size() || !commanded_motions_[number]) return false;
  const HapticsSource::Verdict verdict = source_.note(move, arrival);
  if (verdict == HapticsSource::Verdict::old) return false;
  if (verdict == HapticsSource::Verdict::other) forget_moves();
  return commanded_motions_[number]->begin(to_command(move));
}

void MovedObjects::adopt(const MovedObjects& before) {
  const auto is_same_object = [](const SceneObject& a, const SceneObject& b) { return a.name == b.name; };
  if (before.held() >= 0) view_.clear_tool();
  if (std::ranges::equal(scene_.objects, before.scene_.objects, is_same_object)) {
    source_ = before.source_;
    if (count_shaped_vertices(scene_) == count_shaped_vertices(before.scene_)) shapes_ = before.shapes_;
    for (std::size_t o = 0; o < known_poses_.size(); ++o) {
      if (before.known_poses_[o].serial != 0) take(before.known_poses_[o]);
      const auto& now = scene_.objects[o].commanded;
      const auto& then = before.scene_.objects[o].commanded;
      if (now != nullptr && then != nullptr && *now == *then) commanded_motions_[o] = before.commanded_motions_[o];
    }
  }
  set_time(before.scene_time_ns_);
  place_moving();
}

void MovedObjects::rewind() {
  for (std::size_t o = 0; o < known_poses_.size(); ++o) take(ObjectPose{.object = static_cast<std::int32_t>(o)});
  forget_moves();
  source_ = {};
}

void MovedObjects::forget_shapes() { shapes_ = KnownShapes(count_shaped_vertices(scene_)); }

std::optional<Pose> MovedObjects::pose_of(std::size_t object, double time_s) const {
  if (commanded_motions_[object]) return commanded_motions_[object]->pose_at(time_s);
  const auto& motion = scene_.objects[object].motion;
  return motion != nullptr ? std::optional(motion->pose_at(time_s)) : std::nullopt;
}

bool MovedObjects::set_time(std::int64_t scene_time_ns) {
  scene_time_ns_ = scene_time_ns;
  const double time_s = 1e-9 * static_cast<double>(scene_time_ns);
  bool has_moved = false;
  for (std::size_t o = 0; o < X_SO_.size(); ++o) {
    if (scene_.objects[o].deformation != nullptr) {
      weights_[o] = scene_.objects[o].deformation->weights_at(time_s);
      has_moved = has_moved || weights_[o] != drawn_weights_[o];
    }
    // If no shape is known for this time, the object stays as it is drawn.
    if (const auto place = shapes_.find(o, scene_time_ns)) {
      shape_places_[o] = place;
      has_moved = has_moved || place != drawn_shape_places_[o];
    }
    const auto X_SO = pose_of(o, time_s);
    if (!X_SO) continue;
    has_moved = has_moved || X_SO->matrix() != X_SO_[o].matrix();
    X_SO_[o] = *X_SO;
  }
  return has_moved;
}

void MovedObjects::place_moving() {
  for (std::size_t o = 0; o < X_SO_.size(); ++o) {
    const SceneObject& object = scene_.objects[o];
    if (object.motion != nullptr || object.commanded != nullptr) view_.place_object(o, X_SO_[o], true);
    draw_shape(o);
    if (object.deformation == nullptr || drawn_weights_[o] == weights_[o]) continue;
    view_.reshape_object(o, object.deformation->vertices_at(object.mesh->vertices, weights_[o]));
    drawn_weights_[o] = weights_[o];
  }
}

void MovedObjects::draw_shape(std::size_t object) {
  if (!shape_places_[object]) return;
  // Shapes that came after the time was set may have changed the place, which says between which shapes the object is.
  const auto place = shape_place(object);
  if (!place || drawn_shape_places_[object] == place) return;
  drawn_shape_places_[object] = place;
  view_.reshape_object(object, *find_vertices(object));
}

std::optional<std::vector<Vec3>> MovedObjects::find_vertices(std::size_t object) const {
  const auto place = shape_place(object);
  if (!place) return std::nullopt;
  const std::vector<Vec3>& rest = scene_.objects[object].mesh->vertices;
  if (*place == KnownShapes::Place()) return rest;
  return scene_.objects[object].program_shape->vertices_of(rest, shapes_.displacements_m(object, *place));
}

std::int32_t MovedObjects::held() const {
  for (std::size_t o = 0; o < known_poses_.size(); ++o) {
    if (known_poses_[o].is_held) return static_cast<std::int32_t>(o);
  }
  return -1;
}

Pose MovedObjects::held_pose() const {
  const std::int32_t object = held();
  return object >= 0 ? matrix_of(known_poses_[static_cast<std::size_t>(object)]) : Pose::Identity();
}

std::vector<Pose> MovedObjects::poses() const {
  std::vector<Pose> poses = X_SO_;
  for (std::size_t o = 0; o < known_poses_.size(); ++o) {
    if (!scene_.objects[o].moves() && !known_poses_[o].is_held) poses[o] = matrix_of(known_poses_[o]);
  }
  return poses;
}

// If no pose of the object is known yet, any pose is better than none; all poses are repeated.
bool MovedObjects::is_overtaken(const ObjectPose& pose, Arrival arrival) const {
  const auto number = static_cast<std::size_t>(pose.object);
  return arrival == Arrival::reordered && pose.object >= 0 && number < known_poses_.size() && known_poses_[number].serial != 0;
}

bool MovedObjects::take(const ObjectPose& pose) {
  if (pose.object < 0 || static_cast<std::size_t>(pose.object) >= known_poses_.size()) return false;
  const auto number = static_cast<std::size_t>(pose.object);
  if (scene_.objects[number].moves()) return false;
  ObjectPose& known = known_poses_[number];
  if (is_same(known, pose)) return false;
  const bool was_held = known.is_held;
  known = pose;
  if (pose.is_held) {
    view_.set_tool(tool_of(scene_.objects[number], matrix_of(pose)), true);
  } else if (was_held) {
    view_.clear_tool();
  }
  view_.place_object(number, pose.is_held ? Pose::Identity() : matrix_of(pose), !pose.is_held);
  return true;
}

}  // namespace hapton
