#include "core/force/scene_parts.h"

#include <fmt/core.h>

#include <algorithm>
#include <utility>

#include "core/force/deforming_method.h"
#include "core/force/streamed_method.h"
#include "core/math/rigid_pose.h"

namespace hapton {

void SceneParts::Group::note_materials() noexcept {
  const auto [least, most] = std::ranges::minmax_element(materials, {}, &Material::stiffness_n_per_m);
  stiffness = {least->stiffness_n_per_m, most->stiffness_n_per_m};
  is_frictionless = std::ranges::all_of(shared, [](const Material& material) { return material.friction_dynamic == 0.0; });
}

Result<void> SceneParts::make_method_of(Group& group, Make make, const MethodSettings& settings, const TouchScene& scene) {
  TouchScene part;
  part.part_of = scene.part_of;
  for (const int object : group.objects) {
    part.objects.push_back(scene.objects[static_cast<std::size_t>(object)]);
    TouchObject& own = part.objects.back();
    own.motion = nullptr;
    own.command_pivot.reset();
    group.materials.push_back(own.material);
    group.shared.push_back(shared_material(own.material));
  }
  group.note_materials();
  if (const TouchObject& only = part.objects.front(); only.stream_reach_m) {
    auto streamed = StreamedMethod::make(settings, only.mesh, only.material, *only.stream_reach_m);
    if (!streamed) return tl::unexpected(streamed.error());
    group.streamed = streamed->get();
    group.method = std::move(*streamed);
    return {};
  }
  auto method = group.is_deforming ? DeformingMethod::make(settings, part) : make(settings, part);
  if (!method) return tl::unexpected(method.error());
  group.method = std::move(*method);
  return {};
}

Result<SceneParts> SceneParts::make(Make make, const MethodSettings& settings, const TouchScene& scene) {
  SceneParts parts;
  for (MotionGroup& group : group_by_motion(scene)) {
    std::erase_if(group.objects, [&](int object) { return scene.objects[static_cast<std::size_t>(object)].sculpt.has_value(); });
    if (group.objects.empty()) continue;
    parts.groups_.push_back({std::move(group)});
    if (const auto made = make_method_of(parts.groups_.back(), make, settings, scene); !made) return tl::unexpected(made.error());
  }
  Box bounds;
  for (const TouchObject& object : scene.objects) {
    parts.damping_.push_back(object.material.damping_ns_per_m);
    for (const Vec3& vertex : object.mesh->vertices) bounds.grow(vertex);
  }
  parts.extent_m_ = bounds.diagonal();
  return parts;
}

void SceneParts::reset(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept { groups_[part].method->reset(to_frame(X_SO, p_S)); }

bool SceneParts::resume(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept {
  if (groups_[part].is_deforming) return false;
  groups_[part].method->resume(to_frame(X_SO, p_S));
  return true;
}

MethodOutput SceneParts::feel(std::size_t part, const Pose& X_SO, const Vec3& p_S, const Turn& turn) noexcept {
  Group& group = groups_[part];
  if (std::exchange(group.is_shared, turn.is_shared) != turn.is_shared) group.set_materials();
  const Vec3 p_O = to_frame(X_SO, p_S);
  MethodOutput felt =
      group.method->step({.p_SD = p_O, .dt_s = input_->dt_s, .time_s = input_->time_s, .is_correction = turn.is_correction});
  if (felt.p_SP == p_O) {
    felt.p_SP = p_S;
  } else {
    felt.p_SP = X_SO * felt.p_SP;
    felt.force_n = X_SO.linear() * felt.force_n;
  }
  if (felt.object >= 0) felt.object = group.objects[static_cast<std::size_t>(felt.object)];
  return felt;
}

void SceneParts::set_materials(std::span<const Material> materials) noexcept {
  for (std::size_t i = 0; i < std::min(materials.size(), damping_.size()); ++i) damping_[i] = materials[i].damping_ns_per_m;
  for (Group& group : groups_) {
    for (std::size_t i = 0; i < group.objects.size(); ++i) {
      const auto object = static_cast<std::size_t>(group.objects[i]);
      if (object >= materials.size()) continue;
      group.materials[i] = materials[object];
      group.shared[i] = shared_material(materials[object]);
    }
    group.note_materials();
    group.set_materials();
  }
}

StreamedMethod* SceneParts::find_streamed(int object) noexcept {
  const auto own = [object](const Group& group) { return group.streamed != nullptr && group.objects.front() == object; };
  const auto found = std::find_if(groups_.begin(), groups_.end(), own);
  return found != groups_.end() ? found->streamed : nullptr;
}

std::optional<SurfacePlace> SceneParts::find_place(int object) const noexcept {
  const auto own = [object](const Group& group) { return group.is_deforming && group.objects.front() == object; };
  const auto found = std::find_if(groups_.begin(), groups_.end(), own);
  return found != groups_.end() ? found->method->find_place(0) : std::nullopt;
}

std::vector<int> SceneParts::list_streamed() const {
  std::vector<int> objects;
  for (const Group& group : groups_) {
    if (group.streamed != nullptr) objects.push_back(group.objects.front());
  }
  std::ranges::sort(objects);
  return objects;
}

bool SceneParts::prepare() {
  bool any = false;
  for (Group& group : groups_) any = group.method->prepare() || any;
  return any;
}

std::string SceneParts::describe() const {
  std::string text;
  if (groups_.size() == 1 && has_still()) return groups_.front().method->describe();
  for (const Group& group : groups_) {
    if (group.motion != nullptr) {
      text += fmt::format("objects that move by themselves for {:g} s{}: {}\n", group.motion->duration_s(),
                          group.motion->loops() ? ", repeated" : "", group.objects.size());
    } else if (group.commanded >= 0) {
      text += "objects that programs move: 1\n";
    } else if (!group.is_deforming) {
      text += fmt::format("objects that stand still: {}\n", group.objects.size());
    }
    text += group.method->describe();
  }
  return text;
}

}  // namespace hapton
