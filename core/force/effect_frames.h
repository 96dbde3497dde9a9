#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/force/motion_groups.h"
#include "core/math/types.h"

namespace hapton {

// The frames F in which the effects of surfaces that move or deform are computed (SurfaceFrame): one for each group of objects with the
// same motion (MotionGroup), if any of them has effects. Frame: S. RT: all but construction. Threads: one.
class EffectFrames {
 public:
  explicit EffectFrames(const TouchScene& scene);

  // By object, the number of its frame, from 0; EffectStep::kStill: it stands still, or none of its group has effects. Empty: all kStill.
  const std::vector<int>& of_objects() const { return frame_of_object_; }
  // X_SF of each frame at that sample, by number. Valid until the next call.
  std::span<const Pose> place(const MethodInput& input) noexcept;
  // p_S of an object that keeps its shape, moved to the pose at rest; frames as last placed. Pre: of_objects() is not empty.
  Vec3 at_rest(int object, const Vec3& p_S) const noexcept;

 private:
  std::vector<int> frame_of_object_;
  std::vector<MotionGroup> groups_;  // by number of the frame
  std::vector<Pose> X_SF_;
};

}  // namespace hapton
