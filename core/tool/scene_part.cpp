#include "core/tool/scene_part.h"

#include <utility>

namespace hapton {

ScenePart::ScenePart(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
                     std::shared_ptr<const SceneSurface> scene_surface, std::vector<CoulombFriction> friction, WorkerTeam& team)
    : near_(tool, std::move(tool_surface), scene, std::move(scene_surface), team), friction_(std::move(friction)) {}

ScenePart::ScenePart(const ScenePart& first, const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface,
                     std::vector<CoulombFriction> friction, WorkerTeam& team)
    : near_(first.near_, scene, std::move(scene_surface), team), friction_(std::move(friction)), moves_(true) {}

CoulombFriction ScenePart::friction_of(std::uint32_t object) const noexcept {
  return object < friction_.size() ? friction_[object] : CoulombFriction();
}

void ScenePart::put_at(const Placement& at) noexcept {
  at_ = at;
  turn_ = at.orientation.toRotationMatrix();
}

void ScenePart::put_at_target() noexcept {
  put_at(target_);
  is_moving_ = false;
}

void ScenePart::aim(double share) noexcept {
  is_moving_ = !is_arrived();
  if (!is_moving_) return;
  next_ = share < 1.0 ? motion_between(at_, target_).at(share) : target_;
}

void ScenePart::advance(const RigidMotion& motion, double share, const Placement& tool) noexcept {
  if (!is_moving_) return;
  put_at(share < 1.0 ? tool * in_part_frame(motion).at(share).inverse() : next_);
  is_moving_ = false;
}

RigidMotion ScenePart::in_part_frame(const RigidMotion& motion) const noexcept {
  if (!moves_) return motion;
  const Placement from = in_part_frame(motion.from);
  if (!is_moving_) return {from, turn_.transpose() * motion.shift, turn_.transpose() * motion.turn};
  return motion_between(from, end_in_part_frame(motion));
}

Placement ScenePart::end_in_part_frame(const RigidMotion& motion) const noexcept {
  return is_moving_ ? next_.inverse() * motion.at(1.0) : in_part_frame(motion.at(1.0));
}

Mat6 ScenePart::curvature(const Mat6& in_part) const noexcept {
  if (!moves_) return in_part;
  Mat6 turned;
  for (int i = 0; i < 2; ++i) {
    for (int k = 0; k < 2; ++k) turned.block<3, 3>(3 * i, 3 * k) = turn_ * in_part.block<3, 3>(3 * i, 3 * k) * turn_.transpose();
  }
  return turned;
}

}  // namespace hapton
