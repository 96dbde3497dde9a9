#include "core/tool/patch_front.h"

#include <algorithm>
#include <cmath>

namespace hapton {

PatchFront::PatchFront(const PatchTree& tool, const PatchTree& scene, double radius)
    : tool_(&tool), scene_(&scene), radius_(radius), ended_(kMostEnded), next_(kMostEnded) {}

PatchFront::ToolBox::ToolBox(const PatchTree::Node& node, const SweptMotion& motion) : half(node.half_size()) {
  const Vec3 arm = motion.orientation * node.at();
  for (int i = 0; i < 3; ++i) axes.col(i) = motion.orientation * node.axis(i);
  centre = motion.from.position + arm;
  displacement = motion.displacement(arm);
  const double radius = half.norm();
  const double length = arm.norm();
  still_slack = 0x1p-18 * radius + 0x1p-45 * (1.0 + length);  // the axes are orthonormal to 2^-20
  slack = still_slack + motion.angle * radius + motion.sagitta * (length + radius);
}

PatchFront::Apart PatchFront::test(const ToolBox& tool, const PatchTree::Node& scene, double clearance) noexcept {
  Mat3 axes;
  for (int i = 0; i < 3; ++i) axes.col(i) = scene.axis(i);
  const Vec3 half = scene.half_size();
  const Vec3 between = tool.centre - scene.at();
  const Mat3 cosines = axes.transpose() * tool.axes;
  const Mat3 sizes = cosines.cwiseAbs();
  const auto gaps = [&](const Mat3& along, const Vec3& sum, Vec3& still, Vec3& moved) {
    const Vec3 apart = along.transpose() * between;
    const Vec3 motion = along.transpose() * tool.displacement;
    still = apart.cwiseAbs() - sum;
    // The distance at the end of the motion that is nearer.
    for (int i = 0; i < 3; ++i) moved[i] = still[i] + std::min(0.0, apart[i] < 0.0 ? -motion[i] : motion[i]);
  };
  Vec3 still_scene;
  Vec3 moved_scene;
  gaps(axes, half + sizes * tool.half, still_scene, moved_scene);
  Vec3 still_tool;
  Vec3 moved_tool;
  gaps(tool.axes, tool.half + sizes.transpose() * half, still_tool, moved_tool);
  const double rounding = 0x1p-18 * half.norm() + 0x1p-45 * between.norm();
  const double still = std::max(still_scene.maxCoeff(), still_tool.maxCoeff()) * (1.0 - 0x1p-20) - rounding - tool.still_slack;
  const double moved = std::max(moved_scene.maxCoeff(), moved_tool.maxCoeff()) * (1.0 - 0x1p-20) - rounding - tool.slack;
  return {still, moved > clearance};
}

double PatchFront::begin(const SweptMotion& motion, double distance) noexcept {
  const double rounding = 0x1p-45 * (1.0 + radius_);
  travelled_ += (motion.from.position - at_.position).norm() +
                radius_ * turn_between(at_.orientation, motion.from.orientation).norm() + rounding;
  at_ = motion.from;
  next_count_ = 0;
  tests_ = 0;
  box_node_ = ~0U;
  if (count_ == 0 || count_ > 2 * first_count_ + 64) {
    ended_[0] = {{0, 0}, -1.0};
    count_ = 1;
    first_count_ = 0;
    travelled_ = 0.0;
  }
  return travelled_ + motion.shift.norm() + radius_ * motion.angle + distance + rounding;
}

bool PatchFront::keep(Pair pair, double distance) noexcept {
  if (next_count_ == next_.size()) return false;
  next_[next_count_++] = {pair, distance};
  return true;
}

}  // namespace hapton
