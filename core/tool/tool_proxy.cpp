#include "core/tool/tool_proxy.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Eigenvalues>

namespace hapton {
namespace {

constexpr double kOffset = ToolProxy::kContactOffset;
constexpr double kTolerance = kOffset * 0x1p-7;  // of a bound
constexpr double kLargestTurn = 0.5;             // rad in a round: bounds are good for small ones
constexpr double kLargestTilt = 0.05;            // rad: of what may become a minimum in a round
constexpr int kMostCorrections = 3;
// Bounds of the curvature along a step, over that of the coupling alone: the contacts make a step longer or shorter by these at most.
constexpr double kLeastCurvature = 0.125;
constexpr double kMostCurvature = 64.0;
constexpr std::size_t kManyFeatures = 1024;  // with more, the reach does not grow
constexpr double kNothing = 0x1p-10;         // of the offset: what is left when the device is reached
constexpr double kShrinkage = 0.125;
// Pairs that a round begins with: within a share of its reach.
constexpr double kNearShare = 0x1p-7;
constexpr double kNear = 16.0;  // and offsets
constexpr int kMostExtensions = 8;
constexpr double kGrowth = 4.0;  // of the reach, where it has ended a round

}  // namespace

ToolProxy::ToolProxy(const ObjectGeometry& tool, const TouchGeometry& scene, double turn_length, std::vector<SurfaceFriction> friction,
                     WorkerTeam& team)
    : turn_length_(turn_length),
      friction_(std::move(friction)),
      near_(tool, scene, team),
      bounds_(NearFeatures::kMostFeatures),
      bound_pairs_(NearFeatures::kMostFeatures) {}

bool ToolProxy::overlaps(const Placement& placement) noexcept {
  if (!near_.collect(placement, kOffset, 0.0)) return true;
  for (const NearFeature& near : near_.features()) {
    if (near.gap.distance < kLeastGap * kOffset) return true;
  }
  return near_.any_intersect(placement);  // triangles that intersect need not have near features
}

void ToolProxy::reset(const Placement& device) noexcept {
  near_.restart();
  place(device);
}

void ToolProxy::place(const Placement& device) noexcept {
  proxy_ = last_ = device;
  contact_count_ = 0;
  reach_ = 0.0;
  set_plain_curvature();
  is_blocked_ = overlaps(device);
}

RigidMotion ToolProxy::wanted_motion(const Placement& device) const noexcept {
  return {proxy_, device.position - proxy_.position, turn_between(proxy_.orientation, device.orientation)};
}

Vec6 ToolProxy::to_coordinates(const RigidMotion& motion) const noexcept {
  Vec6 y;
  y << motion.shift, motion.turn;
  return root_ * y;
}

Vec6 ToolProxy::goal_of(const RigidMotion& wanted) const noexcept {
  Vec6 pull;
  pull << wanted.shift, turn_length_ * turn_length_ * wanted.turn;
  return inverse_root_.transpose() * pull;
}

RigidMotion ToolProxy::to_motion(const Vec6& y) const noexcept {
  const Vec6 motion = inverse_root_ * y;
  return {proxy_, motion.head<3>(), motion.tail<3>()};
}

void ToolProxy::update_curvature() noexcept {
  Mat6 curvature = Mat6::Identity();
  curvature.bottomRightCorner<3, 3>() *= turn_length_ * turn_length_;
  for (int k = 0; k < least_.active_count; ++k) {
    const NearFeature& near = near_.features()[bound_pairs_[least_.active[k]]];
    curvature -= least_.multipliers[k] * gap_curvature(near.pair, near.gap, proxy_);
  }
  // In coordinates in which the coupling's own curvature is the identity.
  const Vec6 unit = (Vec6() << Vec3::Ones(), Vec3::Constant(1.0 / turn_length_)).finished();
  const Eigen::SelfAdjointEigenSolver<Mat6> solver(unit.asDiagonal() * curvature * unit.asDiagonal());
  if (solver.info() != Eigen::Success) return set_plain_curvature();
  const Vec6 roots = solver.eigenvalues().cwiseMax(kLeastCurvature).cwiseMin(kMostCurvature).cwiseSqrt();
  const Mat6& axes = solver.eigenvectors();
  // Not symmetric, as any root with root^T root = curvature will do.
  root_ = roots.asDiagonal() * axes.transpose() * unit.cwiseInverse().asDiagonal();
  inverse_root_ = unit.asDiagonal() * axes * roots.cwiseInverse().asDiagonal();
}

void ToolProxy::set_plain_curvature() noexcept {
  const Vec6 unit = (Vec6() << Vec3::Ones(), Vec3::Constant(1.0 / turn_length_)).finished();
  root_ = unit.cwiseInverse().asDiagonal();
  inverse_root_ = unit.asDiagonal();
}

void ToolProxy::make_bounds() noexcept {
  bound_count_ = 0;
  const std::span<const NearFeature> features = near_.features();
  for (std::uint32_t i = 0; i < features.size(); ++i) {
    const FeatureGap& gap = features[i].gap;
    if (!features[i].is_minimum) continue;
    MotionBound& bound = bounds_[bound_count_];
    Vec6 row;
    row << gap.normal, gap.on_tool.cross(gap.normal);
    bound.row = inverse_root_.transpose() * row;
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
    const double lacking = std::max(0.0, near.gap.distance + bounds_[i].row.dot(y) - gap);
    const double least = kOffset - near.gap.distance + lacking;
    if (gap < kOffset - 4.0 * kTolerance && least > bounds_[i].least + kTolerance) is_corrected = true;
    bounds_[i].least = std::max(bounds_[i].least, least);
  }
  return is_corrected;
}

RigidMotion ToolProxy::cut_to(double reach, const RigidMotion& motion) const noexcept {
  const double length = motion.length(near_.radius());
  const double angle = motion.turn.norm();
  const double share = std::min(length > reach ? reach / length : 1.0, angle > kLargestTurn ? kLargestTurn / angle : 1.0);
  return share < 1.0 ? motion.scaled(share) : motion;
}

bool ToolProxy::solve(const Vec6& goal, LeastMotion& least) noexcept {
  const std::span<MotionBound> bounds(bounds_.data(), bound_count_);
  least = find_least_motion(goal, bounds, kTolerance);
  if (least.solved) return true;
  // A pair below the offset asks for more than the others leave: zero motion is always allowed then.
  for (MotionBound& bound : bounds) bound.least = std::min(bound.least, 0.0);
  least = find_least_motion(goal, bounds, kTolerance);
  return least.solved;
}

RigidMotion ToolProxy::constrain(const RigidMotion& wanted, double reach) noexcept {
  make_bounds();
  if (!solve(goal_of(wanted), least_)) return RigidMotion{proxy_};
  RigidMotion motion = cut_to(reach, to_motion(least_.y));
  // What is left of a long motion, and what its curvature does to the gaps, is brought back within the bounds.
  LeastMotion nearest;
  for (int correction = 0; bound_count_ > 0 && correction < kMostCorrections; ++correction) {
    if (!correct_bounds(motion) && correction > 0) break;
    if (!solve(to_coordinates(motion), nearest)) return RigidMotion{proxy_};
    motion = cut_to(reach, to_motion(nearest.y));
  }
  return motion;
}

bool ToolProxy::is_at_rest() const noexcept {
  return least_.solved && least_.active_count > 0 && to_motion(least_.y).length(near_.radius()) <= kConverged * kOffset;
}

// True if the motion brings a minimum from index `first` on below the contact offset.
bool ToolProxy::is_crossed(const RigidMotion& motion, std::size_t first) const noexcept {
  const Placement to = motion.at(1.0);
  const std::span<const NearFeature> added = near_.features().subspan(first);
  return std::any_of(added.begin(), added.end(), [&](const NearFeature& near) {
    return near.is_minimum && gap_along(near.pair, near.gap, proxy_, to) < kOffset - kTolerance;
  });
}

// The share of the motion over which every pair stays at its floor: kFloor of the offset, or a little below where it is, but never below
// kLeastGap; a pair that is there already may only move apart.
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
  const auto shorten = [&] {
    reach_ = 0.5 * reach;
    report.converged = reach_ > kOffset;
    return report.converged;
  };
  if (!near_.collect(proxy_, kNearShare * reach + kNear * kOffset, std::min(2.0 * reach / radius, kLargestTilt))) return shorten();
  RigidMotion motion = constrain(wanted, reach);
  // Pairs that this motion brings together are added, until it crosses none.
  for (int k = 0; !is_at_rest() && k < kMostExtensions; ++k) {
    const std::size_t known = near_.features().size();
    if (!near_.extend(motion, kOffset)) return shorten();
    if (k + 1 == kMostExtensions || !is_crossed(motion, known)) break;
    motion = constrain(wanted, reach);
  }
  report.feature_count = std::max(report.feature_count, near_.features().size());
  note_contacts(report);
  if (is_at_rest()) return false;
  const double length = motion.length(radius);
  if (least_.solved) update_curvature();
  report.converged = false;
  if (length <= kConverged * kOffset) {
    // The bounds of a long motion leave none: those of a shorter one are better.
    reach_ = kShrinkage * reach;
    return reach_ > kOffset;
  }
  const double share = find_safe_share(motion);
  // The motion that was found safe, and no other, leads to the device.
  const RigidMotion rest{proxy_, wanted.shift - motion.shift, wanted.turn - motion.turn};
  if (share >= 1.0 && least_.active_count == 0 && rest.length(radius) <= kNothing * kOffset) {
    proxy_ = device;
    report.converged = true;
    return false;
  }
  proxy_ = motion.at(share);
  if (share >= 1.0 && length >= 0.99 * reach && near_.features().size() < kManyFeatures) reach_ *= kGrowth;
  return true;
}

void ToolProxy::find_local_contacts(double reach, LocalContacts& local) noexcept {
  local.count = 0;
  local.is_blocked = is_blocked_;
  local.proxy = proxy_;
  local.inverse_root = inverse_root_;
  local.plain_inverse_root << Vec3::Ones(), Vec3::Constant(1.0 / turn_length_);
  local.stiffness << Vec3::Ones(), Vec3::Constant(turn_length_ * turn_length_);
  local.tolerance = kTolerance;
  local.is_held = false;
  if (is_blocked_) return;
  while (!near_.collect(proxy_, reach + kOffset, std::min(2.0 * reach / near_.radius(), kLargestTilt))) {
    reach *= kShrinkage;
    local.is_held = reach < kOffset;
    if (local.is_held) return;
  }
  for (const NearFeature& near : near_.features()) {
    if (!near.is_minimum) continue;
    Vec6 row;
    row << near.gap.normal, near.gap.on_tool.cross(near.gap.normal);
    const std::uint32_t object = near_.object_of(near.pair);
    local.add({row, kOffset - near.gap.distance}, {near.gap.on_tool, object < friction_.size() ? friction_[object] : SurfaceFriction()});
  }
}

ToolProxyStep ToolProxy::step(const Placement& device) noexcept {
  ToolProxyStep report;
  if (is_blocked_) place(device);
  if (is_blocked_) {
    report.is_blocked = true;
    return report;
  }
  // In contact the proxy moves about as far as in the step before, and mostly less than the device.
  reach_ =
      1.5 * RigidMotion{last_, proxy_.position - last_.position, turn_between(last_.orientation, proxy_.orientation)}.length(radius()) +
      16.0 * kOffset;
  if (contact_count_ == 0) reach_ = std::max(reach_, wanted_motion(device).length(radius()));
  last_ = proxy_;
  while (report.rounds < kMostRounds) {
    ++report.rounds;
    report.converged = true;
    if (!round(device, report)) break;
  }
  return report;
}

}  // namespace hapton
