#include "core/tool/patch_front.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace hapton {
namespace {

using Floats4 = float __attribute__((vector_size(16)));

Lanes4 lanes_of(const Vec3& v) { return Lanes4{v.x(), v.y(), v.z(), 0.0}; }

// Of three numbers; the last lane is of no use.
Lanes4 lanes_at(const float* from) {
  Floats4 four;
  std::memcpy(&four, from, sizeof(four));
  return __builtin_convertvector(four, Lanes4);
}

Lanes4 absolute(const Lanes4& x) { return detail::lane_max(x, -x); }

// The components of v along axes that are given by coordinate.
Lanes4 along(const Lanes4 (&axes)[3], const Vec3& v) { return v.x() * axes[0] + v.y() * axes[1] + v.z() * axes[2]; }

// What a motion adds to the distance of something at `at` from zero, where it is nearer after it.
Lanes4 approach(const Lanes4& at, const Lanes4& motion) {
  const Lanes4 away = at < 0.0 ? -motion : motion;
  return detail::lane_min(away, Lanes4{});
}

float rounded_down(double x) { return static_cast<float>(x - std::fabs(x) * 0x1p-22 - 0x1p-100); }

// Of the positive ones of three lengths.
double squared(const Lanes4& lengths) {
  const Lanes4 positive = detail::lane_max(lengths, Lanes4{});
  const Lanes4 squares = positive * positive;
  return squares[0] + squares[1] + squares[2];
}

double largest_of(const Lanes4& a, const Lanes4& b) {
  const Lanes4 both = detail::lane_max(a, b);
  return std::max({both[0], both[1], both[2]});
}

}  // namespace

PatchFront::PatchFront(const PatchTree& tool, const PatchTree& scene, double radius)
    : tool_(&tool),
      scene_(&scene),
      radius_(radius),
      ended_(kMostEnded),
      until_(kMostEnded),
      rest_until_(kMostEnded),
      visited_in_(kMostEnded),
      boxes_(kBoxes) {}

void PatchFront::ToolBox::place(const PatchTree::Node& tool, const SweptMotion& motion) {
  const Vec3 arm = motion.orientation * tool.at();
  half = tool.half_size();
  half_lanes = lanes_of(half);
  for (int i = 0; i < 3; ++i) axes.col(i) = motion.orientation * tool.axis(i);
  for (int k = 0; k < 3; ++k) lanes[k] = lanes_of(axes.row(k).transpose());
  centre = motion.from.position + arm;
  displacement = motion.displacement(arm);
  displacement_lanes = along(lanes, displacement);
  const double radius = half.norm();
  const double length = arm.norm();
  still_slack = 0x1p-18 * radius + 0x1p-45 * (1.0 + length);  // the axes are orthonormal to 2^-20
  slack = still_slack + motion.angle * radius + motion.sagitta * (length + radius);
}

const PatchFront::ToolBox& PatchFront::placed(std::uint32_t node, const SweptMotion& motion) noexcept {
  ToolBox& box = boxes_[node % kBoxes];
  if (box.walk != walk_ || box.node != node) {
    box.place(tool_->nodes()[node], motion);
    box.walk = walk_;
    box.node = node;
  }
  return box;
}

PatchFront::Apart PatchFront::test(const ToolBox& tool, const PatchTree::Node& scene, double clearance) noexcept {
  const Lanes4 axes[3] = {lanes_at(scene.axes[0].data()), lanes_at(scene.axes[1].data()), lanes_at(scene.axes[2].data())};
  const Vec3 half = scene.half_size();
  const Vec3 between = tool.centre - scene.at();
  // The sizes of each body's box along the other's axes.
  Lanes4 tool_size{};
  Lanes4 scene_size{};
  for (int i = 0; i < 3; ++i) {
    tool_size += absolute(along(axes, tool.axes.col(i))) * tool.half[i];
    scene_size += absolute(along(tool.lanes, scene.axis(i))) * half[i];
  }
  const Lanes4 by_scene = along(axes, between);
  const Lanes4 by_tool = along(tool.lanes, between);
  const Lanes4 still_scene = absolute(by_scene) - (lanes_of(half) + tool_size);
  const Lanes4 still_tool = absolute(by_tool) - (tool.half_lanes + scene_size);
  const Lanes4 moved_scene = still_scene + approach(by_scene, along(axes, tool.displacement));
  const Lanes4 moved_tool = still_tool + approach(by_tool, tool.displacement_lanes);
  // The axes are orthonormal to 2^-20, coordinates about 1.
  const double rounding = 0x1p-18 * half.sum() + 0x1p-45 * between.cwiseAbs().sum();
  constexpr double kAxisLength = 1.0 - 0x1p-20;  // at least
  // Gaps along axes that are at right angles add up.
  return {std::sqrt(std::max(squared(still_scene), squared(still_tool))) * kAxisLength - 2.0 * (rounding + tool.still_slack),
          largest_of(moved_scene, moved_tool) * kAxisLength - rounding - tool.slack > clearance};
}

float PatchFront::begin(const SweptMotion& motion, double distance) noexcept {
  const double rounding = 0x1p-45 * (1.0 + radius_);
  travelled_ +=
      (motion.from.position - at_.position).norm() + radius_ * turn_between(at_.orientation, motion.from.orientation).norm() + rounding;
  at_ = motion.from;
  tests_ = 0;
  ++walk_;
  if (count_ == 0 || count_ > 2 * first_count_ + 64) {
    ended_[0] = {0, 0};
    until_[0] = rest_until_[0] = -1.0F;
    count_ = 1;
    first_count_ = 0;
    travelled_ = 0.0;
  }
  const double enough = travelled_ + motion.shift.norm() + radius_ * motion.angle + distance + rounding;
  return -rounded_down(-enough);
}

bool PatchFront::keep(Pair pair, double distance, double rest) noexcept {
  std::size_t at = free_;
  free_ = kNone;
  if (at == kNone) at = count_++;
  if (at == ended_.size()) return false;
  ended_[at] = pair;
  until_[at] = rounded_down(travelled_ + distance);
  rest_until_[at] = rounded_down(travelled_ + rest);
  visited_in_[at] = epoch_;
  return true;
}

}  // namespace hapton
