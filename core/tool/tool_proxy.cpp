#include "core/tool/tool_proxy.h"

#include <algorithm>
#include <cmath>

#include "core/collision/triangle_pair.h"

namespace hapton {
namespace {

constexpr double kOffset = ToolProxy::kContactOffset;
constexpr double kTolerance = kOffset * 0x1p-7;  // of a bound
constexpr double kLargestTurn = 0.5;             // rad in a round: bounds are good for small ones
constexpr int kMostCorrections = 3;
constexpr double kGrowth = 4.0;  // of the reach, where it has ended a round

std::array<Vec3, 3> corners_at(const ObjectGeometry& tool, std::uint32_t t, const Placement& placement) {
  return {placement.at(tool.corner(t, 0)), placement.at(tool.corner(t, 1)), placement.at(tool.corner(t, 2))};
}

}  // namespace

ToolProxy::ToolProxy(const ObjectGeometry& tool, const TouchGeometry& scene, double turn_length)
    : tool_(&tool),
      scene_(&scene),
      turn_length_(turn_length),
      near_(tool, scene),
      bounds_(NearFeatures::kMostFeatures),
      bound_pairs_(NearFeatures::kMostFeatures) {}

bool ToolProxy::overlaps(const Placement& placement) noexcept {
  if (!near_.collect(placement, kOffset)) return true;
  for (const NearFeature& near : near_.features()) {
    if (near.gap.distance < kLeastGap * kOffset) return true;
  }
  // Triangles that intersect need not have near features.
  for (const TrianglePairIds& ids : near_.triangle_pairs()) {
    const ObjectGeometry::Corners c = scene_->corners(ids.scene);
    if (intersect_triangles({corners_at(*tool_, ids.tool, placement), {c.a, c.b, c.c}}).meets) return true;
  }
  return false;
}

void ToolProxy::reset(const Placement& device) noexcept {
  proxy_ = device_ = device;
  contact_count_ = 0;
  reach_ = 0.0;
  is_blocked_ = overlaps(device);
}

RigidMotion ToolProxy::wanted_motion(const Placement& device) const noexcept {
  return {proxy_, device.position - proxy_.position, turn_between(proxy_.orientation, device.orientation)};
}

Vec6 ToolProxy::to_coordinates(const RigidMotion& motion) const noexcept {
  Vec6 y;
  y << motion.shift, turn_length_ * motion.turn;
  return y;
}

RigidMotion ToolProxy::to_motion(const Vec6& y) const noexcept { return {proxy_, y.head<3>(), y.tail<3>() / turn_length_}; }

void ToolProxy::make_bounds() noexcept {
  bound_count_ = 0;
  const std::span<const NearFeature> features = near_.features();
  for (std::uint32_t i = 0; i < features.size(); ++i) {
    const FeatureGap& gap = features[i].gap;
    if (!features[i].is_minimum) continue;
    MotionBound& bound = bounds_[bound_count_];
    bound.row << gap.normal, gap.on_tool.cross(gap.normal) / turn_length_;
    bound.least = kOffset - gap.distance;
    bound_pairs_[bound_count_++] = i;
  }
}

// Bounds are linear in the motion; gaps are not. Raises each bound by what the gap after the motion lacks. True if one was raised by
// more than a bound's tolerance.
bool ToolProxy::correct_bounds(const RigidMotion& motion) noexcept {
  const Vec6 y = to_coordinates(motion);
  const Placement to = motion.at(1.0);
  bool is_corrected = false;
  for (std::size_t i = 0; i < bound_count_; ++i) {
    const NearFeature& near = near_.features()[bound_pairs_[i]];
    const double gap = gap_along(near.pair, near.gap, proxy_, to);
    const double lacking = near.gap.distance + bounds_[i].row.dot(y) - gap;
    const double least = kOffset - near.gap.distance + lacking;
    if (gap < kOffset - 4.0 * kTolerance && least > bounds_[i].least + kTolerance) is_corrected = true;
    bounds_[i].least = least;
  }
  return is_corrected;
}

RigidMotion ToolProxy::cut_to(double reach, const RigidMotion& motion) const noexcept {
  const double length = motion.length(near_.radius());
  const double angle = motion.turn.norm();
  const double share = std::min(length > reach ? reach / length : 1.0, angle > kLargestTurn ? kLargestTurn / angle : 1.0);
  return share < 1.0 ? motion.scaled(share) : motion;
}

RigidMotion ToolProxy::constrain(const RigidMotion& wanted, double reach) noexcept {
  make_bounds();
  const std::span<MotionBound> bounds(bounds_.data(), bound_count_);
  const Vec6 goal = to_coordinates(wanted);
  RigidMotion motion{proxy_};
  for (int correction = 0; correction <= kMostCorrections; ++correction) {
    least_ = find_least_motion(goal, bounds, kTolerance);
    if (!least_.solved) {
      // A pair below the offset asks for more than the others leave: zero motion is always allowed then.
      for (MotionBound& bound : bounds) bound.least = std::min(bound.least, 0.0);
      least_ = find_least_motion(goal, bounds, kTolerance);
      return least_.solved ? cut_to(reach, to_motion(least_.y)) : RigidMotion{proxy_};
    }
    motion = cut_to(reach, to_motion(least_.y));
    if (bound_count_ == 0 || !correct_bounds(motion)) break;
  }
  return motion;
}

double ToolProxy::find_safe_share(const RigidMotion& motion) const noexcept {
  double until = 1.0;
  for (const NearFeature& near : near_.features()) {
    const double d = near.gap.distance;
    const double floor = std::min(d, std::max(kLeastGap * kOffset, std::min(kFloor * kOffset, d - kOffset * 0x1p-8)));
    until = find_safe_time(near.pair, near.gap, motion, floor, until);
    if (!(until > 0.0)) return 0.0;
  }
  return until;
}

void ToolProxy::note_contacts(ToolProxyStep& report) noexcept {
  contact_count_ = least_.solved ? least_.active_count : 0;
  for (int k = 0; k < contact_count_; ++k) {
    const NearFeature& near = near_.features()[bound_pairs_[least_.active[k]]];
    contacts_[k] = {near.gap.on_scene, near.gap.normal, least_.multipliers[k], near.pair.tool_triangle, near.pair.scene_triangle};
  }
  report.haptons = 0;
  for (const NearFeature& near : near_.features()) report.haptons += near.is_minimum && near.gap.distance < 2.0 * kOffset ? 1 : 0;
}

// True if there is more to do.
bool ToolProxy::round(const Placement& device, ToolProxyStep& report) noexcept {
  const RigidMotion wanted = wanted_motion(device);
  const double radius = near_.radius();
  const double left = wanted.length(radius);
  contact_count_ = 0;
  if (!(left > 0.0)) return false;
  const double reach = std::min(left, reach_);
  if (!near_.collect(proxy_, reach + kOffset)) {
    reach_ = 0.5 * reach;
    report.converged = reach_ > kOffset;
    return report.converged;
  }
  report.feature_count = std::max(report.feature_count, near_.features().size());
  const RigidMotion motion = constrain(wanted, reach);
  const double length = motion.length(radius);
  note_contacts(report);
  if (length <= kConverged * kOffset && least_.active_count > 0) return false;
  const double share = find_safe_share(motion);
  if (share >= 1.0 && least_.active_count == 0 && reach == left && wanted.turn.norm() <= kLargestTurn) {
    proxy_ = device;
    return false;
  }
  proxy_ = motion.at(share);
  if (share >= 1.0 && length >= 0.99 * reach) reach_ *= kGrowth;
  report.converged = false;
  return true;
}

ToolProxyStep ToolProxy::step(const Placement& device) noexcept {
  ToolProxyStep report;
  if (is_blocked_) reset(device);
  if (is_blocked_) {
    report.is_blocked = true;
    return report;
  }
  const RigidMotion moved{device_, device.position - device_.position, turn_between(device_.orientation, device.orientation)};
  reach_ = 2.0 * moved.length(near_.radius()) + 16.0 * kOffset;
  device_ = device;
  while (report.rounds < kMostRounds) {
    ++report.rounds;
    report.converged = true;
    if (!round(device, report)) break;
  }
  return report;
}

}  // namespace hapton
