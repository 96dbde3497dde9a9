#include "core/force/effect_frames.h"

#include <algorithm>
#include <utility>

#include "core/effects/effect_step.h"
#include "core/math/rigid_pose.h"

namespace hapton {

EffectFrames::EffectFrames(const TouchScene& scene) {
  const auto has_effects = [&](int object) { return scene.objects[static_cast<std::size_t>(object)].effects.any(); };
  for (MotionGroup& group : group_by_motion(scene)) {
    if (!group.moves() || !std::any_of(group.objects.begin(), group.objects.end(), has_effects)) continue;
    frame_of_object_.resize(scene.objects.size(), EffectStep::kStill);
    for (const int object : group.objects) frame_of_object_[static_cast<std::size_t>(object)] = static_cast<int>(groups_.size());
    groups_.push_back(std::move(group));
  }
  X_SF_.resize(groups_.size(), Pose::Identity());
}

std::span<const Pose> EffectFrames::place(const MethodInput& input) noexcept {
  for (std::size_t g = 0; g < groups_.size(); ++g) X_SF_[g] = groups_[g].pose_at(input);
  return X_SF_;
}

Vec3 EffectFrames::at_rest(int object, const Vec3& p_S) const noexcept {
  const int frame = frame_of_object_[static_cast<std::size_t>(object)];
  return frame == EffectStep::kStill ? p_S : to_frame(X_SF_[static_cast<std::size_t>(frame)], p_S);
}

}  // namespace hapton
