#include "core/force/moving_method.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/deforming_method.h"

namespace hapton {
namespace {

bool is_same_motion(const KeyframeMotion* a, const KeyframeMotion* b) { return a == b || (a != nullptr && b != nullptr && *a == *b); }

Vec3 to_frame(const Pose& X_SO, const Vec3& p_S) { return X_SO.linear().transpose() * (p_S - X_SO.translation()); }

}  // namespace

// What stands still first and last, the others in the order of the scene.
std::vector<MovingMethod::Group> MovingMethod::group_objects(const TouchScene& scene) {
  std::vector<Group> groups;
  int commanded = 0;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const auto& motion = scene.objects[o].motion;
    const bool is_deforming = scene.objects[o].deformation != nullptr;
    const bool is_alone = is_deforming || scene.objects[o].command_pivot.has_value();
    const auto same = [&](const Group& group) {
      return !is_alone && !group.is_alone() && is_same_motion(group.motion.get(), motion.get());
    };
    auto found = std::find_if(groups.begin(), groups.end(), same);
    if (found == groups.end()) found = groups.insert(groups.end(), Group{.motion = motion, .objects = {}, .is_deforming = is_deforming});
    if (scene.objects[o].command_pivot) found->commanded = commanded++;
    found->objects.push_back(static_cast<int>(o));
  }
  std::stable_partition(groups.begin(), groups.end(), [](const Group& group) { return !group.moves(); });
  if (!groups.front().moves()) groups.push_back({.motion = nullptr, .objects = groups.front().objects, .is_second = true});
  return groups;
}

Material MovingMethod::material_in(const Group& group, const Material& material) noexcept {
  if (!group.is_second) return material;
  return {.stiffness_n_per_m = material.stiffness_n_per_m, .two_sided = material.two_sided};
}

Result<void> MovingMethod::make_method_of(Group& group, Make make, const MethodSettings& settings, const TouchScene& scene) {
  TouchScene part;
  for (const int object : group.objects) {
    part.objects.push_back(scene.objects[static_cast<std::size_t>(object)]);
    TouchObject& own = part.objects.back();
    own.motion = nullptr;
    own.command_pivot.reset();
    own.material = material_in(group, own.material);
    group.materials.push_back(own.material);
  }
  MethodSettings own = settings;
  // It takes part when something pushes, and all of it must be there then.
  if (group.is_second) own.build_on_approach = false;
  auto method = group.is_deforming ? DeformingMethod::make(own, part) : make(own, part);
  if (!method) return tl::unexpected(method.error());
  group.method = std::move(*method);
  return {};
}

Result<std::unique_ptr<ForceMethod>> MovingMethod::make(Make make, const MethodSettings& settings, const TouchScene& scene) {
  std::vector<Group> groups = group_objects(scene);
  for (Group& group : groups) {
    if (const auto made = make_method_of(group, make, settings, scene); !made) return tl::unexpected(made.error());
  }
  return std::unique_ptr<ForceMethod>(new MovingMethod(std::move(groups)));
}

bool MovingMethod::feel(Group& group, const Pose& X_SO, const MethodInput& input, MethodOutput& output, double& most_n) noexcept {
  const MethodOutput felt = group.method->step({.p_SD = to_frame(X_SO, output.p_SP), .dt_s = input.dt_s, .time_s = input.time_s});
  if (!felt.contact) return false;
  output.contact = true;
  output.force_n += X_SO.linear() * felt.force_n;
  output.p_SP = X_SO * felt.p_SP;
  if (const double pushes = felt.force_n.norm(); felt.object >= 0 && pushes >= most_n) {
    most_n = pushes;
    output.object = group.objects[static_cast<std::size_t>(felt.object)];
  }
  return true;
}

Pose MovingMethod::Group::pose_at(const MethodInput& input) const noexcept {
  if (commanded >= 0 && static_cast<std::size_t>(commanded) < input.commanded.size()) {
    return input.commanded[static_cast<std::size_t>(commanded)];
  }
  return motion != nullptr ? motion->pose_at(input.time_s) : Pose(Pose::Identity());
}

MethodOutput MovingMethod::step(const MethodInput& input) noexcept {
  MethodOutput output{.force_n = Vec3::Zero(), .p_SP = input.p_SD};
  if (!input.p_SD.allFinite() || !std::isfinite(input.time_s)) return output;
  const bool begins = start_.has_value();
  const Vec3 last = start_.value_or(last_p_SP_.value_or(input.p_SD));
  const bool was_pushed = std::exchange(is_pushed_, false) && !begins;
  double most_n = 0.0;
  for (Group& group : groups_) {
    if (group.is_second) {
      if (!is_pushed_) continue;
      // It was where the proxy was, which all others have left outside of what stands still.
      if (!was_pushed) group.method->resume(last);
      feel(group, Pose::Identity(), input, output, most_n);
      continue;
    }
    const Pose X_SO = group.pose_at(input);
    if (begins) group.method->reset(to_frame(X_SO, last));
    const bool is_touched = feel(group, X_SO, input, output, most_n);
    is_pushed_ = is_pushed_ || (is_touched && group.moves());
  }
  start_.reset();
  last_p_SP_ = output.p_SP;
  return output;
}

void MovingMethod::set_materials(std::span<const Material> materials) noexcept {
  for (Group& group : groups_) {
    for (std::size_t i = 0; i < group.objects.size(); ++i) {
      const auto object = static_cast<std::size_t>(group.objects[i]);
      if (object < materials.size()) group.materials[i] = material_in(group, materials[object]);
    }
    group.method->set_materials(group.materials);
  }
}

bool MovingMethod::prepare() {
  bool any = false;
  for (Group& group : groups_) any = group.method->prepare() || any;
  return any;
}

std::string MovingMethod::describe() const {
  std::string text;
  for (const Group& group : groups_) {
    if (group.is_second) continue;
    if (group.motion != nullptr) {
      text += fmt::format("{} of the objects move by themselves for {:g} s{}:\n", group.objects.size(), group.motion->duration_s(),
                          group.motion->loops() ? ", again and again" : "");
    } else if (group.commanded >= 0) {
      text += "1 of the objects moves where programs command it:\n";
    } else if (!group.is_deforming) {
      text += fmt::format("{} of the objects stand still, and are built twice:\n", group.objects.size());
    }
    text += group.method->describe();
  }
  return text;
}

}  // namespace hapton
