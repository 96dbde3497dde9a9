#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/force/motion_groups.h"
#include "core/math/types.h"

namespace hapton {

// The frames in which the effects of a scene's surfaces are computed where these move or deform (SurfaceFrame): one for the objects of each
// motion, of those that have effects. Frame: S. RT: place yes, the rest set-up only. Threads: one.
class EffectFrames {
 public:
  explicit EffectFrames(const TouchScene& scene);

  // By object, the number of its frame, from 0; EffectStep::kStill: it stands still, or has no effects. Empty: all do.
  const std::vector<int>& of_objects() const { return of_objects_; }
  // Where they are at that sample, by number, until the next call.
  std::span<const Pose> place(const MethodInput& input) noexcept;
  // The same point of the object at rest, for one that keeps its shape.
  Vec3 at_rest(int object, const Vec3& p_S) const noexcept;

 private:
  std::vector<int> of_objects_;
  std::vector<MotionGroup> groups_;  // by number
  std::vector<Pose> X_SF_;
};

}  // namespace hapton
