#include "core/tool/tool_proxy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/tool/time_of_impact.h"

namespace hapton {
namespace {

constexpr double kOffset = ToolProxy::kContactOffset;
constexpr double kLargestTurn = 0.5;  // rad in a round: the linear bounds are good for small turns
constexpr int kMaxCorrections = 3;
constexpr std::size_t kManyFeatures = 1024;  // pairs of features; with more, the reach does not grow
constexpr std::size_t kMaxFollowed = 96;     // pairs that are followed, or twice those of a search: of more, most are behind the tool
constexpr double kMaxRemaining = 0x1p-10;    // of the offset: if no more of the motion is left, the device is reached
// A round begins with the pairs within a distance: this share of its reach, ...
constexpr double kNearShare = 0x1p-8;
constexpr double kNearOffsets = 2.0;  // ... plus this many offsets
// If no contact holds a motion, a first part of it is searched alone: it may lead straight into a surface, however far the last one went.
constexpr double kFirstShare = 0x1p-8;     // share of the motion
constexpr double kMinFirstOffsets = 16.0;  // in offsets, at least
constexpr int kMaxExtensions = 8;
// While the device is far below the surface on which a tool slides, a small slide brings the tool nearer by a far smaller distance.
constexpr double kMinGain = kOffset * 0x1p-12;
constexpr double kGrowth = 4.0;  // factor of the reach, if it has ended a round, or of the part of a motion that is searched

}  // namespace

ToolProxy::ToolProxy(const ObjectGeometry& tool, const TouchGeometry& scene, double turn_length, std::vector<CoulombFriction> friction,
                     WorkerTeam& team)
    : ToolProxy(tool, std::make_shared<const ToolSurface>(tool), scene, std::make_shared<const SceneSurface>(scene), turn_length,
                std::move(friction), team) {}

ToolProxy::ToolProxy(const ObjectGeometry& tool, std::shared_ptr<const ToolSurface> tool_surface, const TouchGeometry& scene,
                     std::shared_ptr<const SceneSurface> scene_surface, double turn_length, std::vector<CoulombFriction> friction,
                     WorkerTeam& team)
    : energy_(turn_length),
      progress_(kMinGain),
      team_(&team),
      bounds_(NearFeatures::kMaxFeatures),
      bound_pairs_(NearFeatures::kMaxFeatures),
      part_motions_(NearFeatures::kMaxFeatures),
      known_counts_(1) {
  parts_.push_back(std::make_unique<ScenePart>(tool, std::move(tool_surface), scene, std::move(scene_surface), std::move(friction), team));
}

void ToolProxy::add_part(const TouchGeometry& scene, std::shared_ptr<const SceneSurface> scene_surface,
                         std::vector<CoulombFriction> friction) {
  parts_.push_back(std::make_unique<ScenePart>(*parts_[0], scene, std::move(scene_surface), std::move(friction), *team_));
  const std::size_t most = parts_.size() * NearFeatures::kMaxFeatures;
  bounds_.resize(most);
  bound_pairs_.resize(most);
  part_motions_.resize(most);
  known_counts_.resize(parts_.size());
}

double ToolProxy::travel_to(std::span<const Placement> parts) const noexcept {
  double travel = 0.0;
  for (std::size_t p = 1; p < parts_.size() && p <= parts.size(); ++p) {
    const Placement& target = parts_[p]->target();
    if (!(target == parts[p - 1])) travel = std::max(travel, relative_travel_bound(proxy_, radius(), target, parts[p - 1]));
  }
  return travel;
}

void ToolProxy::set_targets(std::span<const Placement> parts) noexcept {
  travel_ = travel_to(parts);
  for (std::size_t p = 1; p < parts_.size() && p <= parts.size(); ++p) parts_[p]->set_target(parts[p - 1]);
}

bool ToolProxy::collect(const Placement& placement, double distance, double turn) noexcept {
  return std::all_of(parts_.begin(), parts_.end(),
                     [&](const auto& part) { return part->near().collect(part->in_part_frame(placement), distance, turn); });
}

bool ToolProxy::extend(const RigidMotion& motion, double distance) noexcept {
  return std::all_of(parts_.begin(), parts_.end(),
                     [&](const auto& part) { return part->near().extend(part->in_part_frame(motion), distance); });
}

void ToolProxy::follow(const Placement& placement, double turn) noexcept {
  for (const auto& part : parts_) part->near().follow(part->in_part_frame(placement), turn);
}

std::size_t ToolProxy::feature_count() const noexcept {
  std::size_t count = 0;
  for (const auto& part : parts_) count += part->near().features().size();
  return count;
}

bool ToolProxy::overlaps(const Placement& placement) noexcept {
  if (!collect(placement, kOffset, 0.0)) return true;
  for (const auto& part : parts_) {
    for (const NearFeature& near : part->near().features()) {
      if (near.gap.distance < kMinGap * kOffset) return true;
    }
    if (part->near().any_intersect(part->in_part_frame(placement))) return true;  // triangles that intersect need not have near features
  }
  return false;
}

void ToolProxy::reset(const Placement& device, std::span<const Placement> parts) noexcept {
  set_targets(parts);
  for (const auto& part : parts_) part->near().restart();
  place(device);
}

void ToolProxy::place(const Placement& device) noexcept {
  proxy_ = last_proxy_ = device;
  contacts_.count = 0;
  reach_ = local_reach_limit_ = 0.0;
  for (std::size_t p = 1; p < parts_.size(); ++p) parts_[p]->put_at_target();
  energy_.set_plain();
  is_blocked_ = overlaps(device);
}

void ToolProxy::update_curvature() noexcept {
  Mat6 curvature = energy_.coupling_curvature();
  for (int k = 0; k < least_.active_count; ++k) {
    const BoundPair& pair = bound_pairs_[least_.active[k]];
    const NearFeature& near = near_of(pair);
    const ScenePart& part = *parts_[pair.part];
    curvature -= least_.multipliers[k] * part.curvature(gap_curvature(near.pair, near.gap, part.in_part_frame(proxy_)));
  }
  energy_.set_curvature(curvature);
}

void ToolProxy::make_bounds() noexcept {
  bound_count_ = 0;
  for (std::uint32_t p = 0; p < parts_.size(); ++p) {
    const ScenePart& part = *parts_[p];
    // The motion of the tool relative to the part, if the part moves and the tool does not.
    const Vec6 passing = part.is_moving() ? part.in_part_frame(RigidMotion{proxy_}).shift_and_turn() : Vec6(Vec6::Zero());
    const std::span<const NearFeature> features = part.near().features();
    for (std::uint32_t i = 0; i < features.size(); ++i) {
      const FeatureGap& gap = features[i].gap;
      if (!features[i].is_minimum) continue;
      MotionBound& bound = bounds_[bound_count_];
      const Vec3 lever = gap.on_tool.cross(gap.normal);
      Vec6 row;
      row << part.direction(gap.normal), part.direction(lever);
      bound.row = energy_.to_row(row);
      bound.least = kOffset - gap.distance;
      if (part.is_moving()) {
        part_motions_[bound_count_] = -(gap.normal.dot(passing.head<3>()) + lever.dot(passing.tail<3>()));
        bound.least += part_motions_[bound_count_];
      } else {
        part_motions_[bound_count_] = 0.0;
      }
      bound_pairs_[bound_count_++] = {p, i};
    }
  }
}

// Bounds are linear in the motion; gaps are not. Raises each bound by how far the gap after the motion is below the linear one. True if one
// whose gap is too small was raised by more than a bound's tolerance.
bool ToolProxy::correct_bounds(const RigidMotion& motion) noexcept {
  const Vec6 y = energy_.to_coordinates(motion);
  bool is_corrected = false;
  for (std::size_t i = 0; i < bound_count_;) {
    const std::uint32_t p = bound_pairs_[i].part;
    const Placement from = parts_[p]->in_part_frame(proxy_);
    const Placement to = parts_[p]->end_in_part_frame(motion);
    for (; i < bound_count_ && bound_pairs_[i].part == p; ++i) {
      const NearFeature& near = near_of(bound_pairs_[i]);
      const double gap = gap_along(near.pair, near.gap, from, to);
      const double lacking = std::max(0.0, near.gap.distance - part_motions_[i] + bounds_[i].row.dot(y) - gap);
      const double least = kOffset - near.gap.distance + part_motions_[i] + lacking;
      if (gap < kOffset - 4.0 * kTolerance && least > bounds_[i].least + kTolerance) is_corrected = true;
      bounds_[i].least = std::max(bounds_[i].least, least);
    }
  }
  return is_corrected;
}

RigidMotion ToolProxy::cut_to(double reach, const RigidMotion& motion) const noexcept {
  const double length = motion.length(radius());
  const double angle = motion.turn.norm();
  const double share = std::min(length > reach ? reach / length : 1.0, angle > kLargestTurn ? kLargestTurn / angle : 1.0);
  return share < 1.0 ? motion.scaled(share) : motion;
}

bool ToolProxy::solve(const Vec6& goal, LeastMotion& least) noexcept {
  const std::span<MotionBound> bounds(bounds_.data(), bound_count_);
  least = find_least_motion(goal, bounds, kTolerance);
  if (least.solved) return true;
  // A pair below the offset may ask for more than the others leave: then zero motion is always allowed, if no part moves.
  for (std::size_t i = 0; i < bound_count_; ++i) bounds_[i].least = std::min(bounds_[i].least, part_motions_[i]);
  least = find_least_motion(goal, bounds, kTolerance);
  return least.solved;
}

RigidMotion ToolProxy::constrain(const RigidMotion& wanted, double reach) noexcept {
  make_bounds();
  if (!solve(energy_.goal_of(wanted), least_)) return RigidMotion{proxy_};
  RigidMotion motion = cut_to(reach, energy_.to_motion(proxy_, least_.y));
  // Brings back within the bounds what has left them because a long motion was cut, and because its curvature changes the gaps.
  LeastMotion nearest;
  for (int correction = 0; bound_count_ > 0 && correction < kMaxCorrections; ++correction) {
    if (!correct_bounds(motion) && correction > 0) break;
    if (!solve(energy_.to_coordinates(motion), nearest)) return RigidMotion{proxy_};
    motion = cut_to(reach, energy_.to_motion(proxy_, nearest.y));
  }
  return motion;
}

bool ToolProxy::is_at_rest() const noexcept {
  return least_.solved && least_.active_count > 0 && energy_.to_motion(proxy_, least_.y).length(rest_radius()) <= kConverged * kOffset;
}

void ToolProxy::count_known() noexcept {
  for (std::size_t p = 0; p < parts_.size(); ++p) known_counts_[p] = parts_[p]->near().features().size();
}

// True if the motion brings a minimum that was added since count_known below the contact offset.
bool ToolProxy::is_crossed(const RigidMotion& motion) const noexcept {
  for (std::size_t p = 0; p < parts_.size(); ++p) {
    const ScenePart& part = *parts_[p];
    const std::span<const NearFeature> added = part.near().features().subspan(known_counts_[p]);
    if (added.empty()) continue;
    const Placement from = part.in_part_frame(proxy_);
    const Placement to = part.end_in_part_frame(motion);
    const bool is_any = std::any_of(added.begin(), added.end(), [&](const NearFeature& near) {
      return near.is_minimum && gap_along(near.pair, near.gap, from, to) < kOffset - kTolerance;
    });
    if (is_any) return true;
  }
  return false;
}

// The share of the motion over which every pair stays at its floor or above: kFloor of the offset, or a little below its present distance
// if that is less, but never below kMinGap. A pair that is already nearer than kMinGap may only move apart.
double ToolProxy::find_safe_share(const RigidMotion& motion) const noexcept {
  double until = 1.0;
  for (const auto& part : parts_) {
    const RigidMotion part_motion = part->in_part_frame(motion);
    for (const NearFeature& near : part->near().features()) {
      const double d = near.gap.distance;
      const double floor = std::min(d, std::max(kMinGap * kOffset, std::min(kFloor * kOffset, d - kOffset * 0x1p-8)));
      until = bound_time_of_impact(near.pair, near.gap, part_motion, floor, until);
      if (!(until > 0.0)) return 0.0;
    }
  }
  return until;
}

void ToolProxy::note_contacts(ToolProxyStep& report) noexcept {
  contacts_.count = least_.solved ? least_.active_count : 0;
  for (int k = 0; k < contacts_.count; ++k) {
    const BoundPair& pair = bound_pairs_[least_.active[k]];
    const NearFeature& near = near_of(pair);
    const ScenePart& part = *parts_[pair.part];
    contacts_.all[k] = {part.point(near.gap.on_scene), part.direction(near.gap.normal), least_.multipliers[k],
                        near.pair.tool_triangle,       near.pair.scene_triangle,        static_cast<int>(pair.part)};
  }
  report.haptons = 0;
  for (const auto& part : parts_) {
    for (const NearFeature& near : part->near().features()) report.haptons += near.is_minimum && near.gap.distance < 2.0 * kOffset ? 1 : 0;
  }
  if (progress_.is_best()) best_contacts_ = contacts_;
}

void ToolProxy::return_to_best() noexcept {
  proxy_ = progress_.best();
  contacts_ = best_contacts_;
}

bool ToolProxy::extend_until_clear(const RigidMotion& wanted, double reach, double searched_length, RigidMotion& motion) noexcept {
  for (int k = 0; k < kMaxExtensions && !(std::isfinite(reach) && is_at_rest()); ++k) {
    count_known();
    const bool is_last = k + 1 == kMaxExtensions;
    const double length = motion.length(radius());
    const bool is_part = length > 2.0 * searched_length && !is_last;
    if (!extend(is_part ? motion.scaled(searched_length / length) : motion, kOffset)) return false;
    if (is_crossed(motion) && !is_last) {
      motion = constrain(wanted, reach);
    } else if (is_part) {
      searched_length *= kGrowth;
    } else {
      break;
    }
  }
  return true;
}

// Makes one round of a step. True if there is more to do.
bool ToolProxy::round(const Placement& device, ToolProxyStep& report) noexcept {
  const RigidMotion wanted = motion_between(proxy_, device);
  const double radius = this->radius();
  const double remaining = wanted.length(radius);
  if (remaining > 0.0 && progress_.begin_round(proxy_, energy_.length(wanted))) {
    // From round to round the gaps, and so the distance to the device, vary by less than an offset: a smaller gain does not count.
    if (energy_.length(motion_between(progress_.best(), device)) < energy_.length(wanted) - kOffset) return_to_best();
    report.converged = false;
    return false;
  }
  contacts_.count = 0;
  if (!(remaining > 0.0)) return false;
  const double reach = std::min(remaining, reach_);
  const auto shorten = [&] {
    reach_ = 0.5 * reach;
    report.is_frozen = true;
    report.converged = reach_ > kOffset;
    return report.converged;
  };
  const double turn = std::min(2.0 * reach / radius, kLargestTilt);
  if (std::exchange(follows_, false)) {
    follow(proxy_, turn);
  } else if (collect(proxy_, kNearShare * reach + kNearOffsets * kOffset, turn)) {
    max_followed_ = std::max(kMaxFollowed, 2 * feature_count());
  } else {
    return shorten();
  }
  RigidMotion motion = constrain(wanted, reach);
  const double first = std::max(kMinFirstOffsets * kOffset, kFirstShare * motion.length(radius));
  const double searched_length = least_.active_count == 0 ? std::min(searched_length_, first) : searched_length_;
  if (!extend_until_clear(wanted, reach, searched_length, motion)) return shorten();
  report.is_frozen = false;
  report.feature_count = std::max(report.feature_count, feature_count());
  note_contacts(report);
  if (is_at_rest()) return false;
  const double length = motion.length(radius);
  if (least_.solved) update_curvature();
  report.converged = false;
  if (motion.length(rest_radius()) <= kConverged * kOffset) {
    // The bounds for a long motion allow hardly any motion; those for a shorter one are better.
    reach_ = kShrinkage * reach;
    return reach_ > kOffset;
  }
  const double share = find_safe_share(motion);
  // The proxy is put at the device only if the motion that was found safe leads there.
  const RigidMotion remaining_motion{proxy_, wanted.shift - motion.shift, wanted.turn - motion.turn};
  if (share >= 1.0 && least_.active_count == 0 && remaining_motion.length(radius) <= kMaxRemaining * kOffset) {
    proxy_ = device;
    report.converged = true;
    return false;
  }
  proxy_ = motion.at(share);
  follows_ = feature_count() <= max_followed_;
  searched_length_ = std::max(searched_length_, share * length);
  if (share >= 1.0 && length >= 0.99 * reach && feature_count() < kManyFeatures) reach_ *= kGrowth;
  return true;
}

// True if a moving part would come nearer than the offset and nearer than it is now: the tool has no room.
bool ToolProxy::is_squeezed_by(const RigidMotion& motion) const noexcept {
  for (const auto& part : parts_) {
    if (!part->is_moving()) continue;
    const Placement from = part->in_part_frame(proxy_);
    const Placement to = part->end_in_part_frame(motion);
    for (const NearFeature& near : part->near().features()) {
      if (!near.is_minimum) continue;
      const double least = std::min(kOffset - kTolerance, near.gap.distance) - 0x1p-6 * kTolerance;
      if (gap_along(near.pair, near.gap, from, to) < least) return true;
    }
  }
  return false;
}

bool ToolProxy::find_push(RigidMotion& motion) noexcept {
  constexpr double kAny = std::numeric_limits<double>::infinity();
  const RigidMotion still{proxy_};
  motion = constrain(still, kAny);
  return extend_until_clear(still, kAny, kAny, motion) && !is_squeezed_by(motion);
}

double ToolProxy::carry_round(double length) noexcept {
  const RigidMotion still{proxy_};
  const double distance = kNearShare * length + kNearOffsets * kOffset;
  const double turn = std::min(2.0 * length / radius(), kLargestTilt);
  bool is_near = false;
  for (const auto& part : parts_) {
    if (!part->is_moving()) continue;
    NearFeatures& near = part->near();
    if (!near.collect(part->in_part_frame(proxy_), distance, turn) || !near.extend(part->in_part_frame(still), kOffset)) return 0.0;
    is_near = is_near || !near.features().empty();
  }
  RigidMotion motion = still;
  double share = 1.0;
  if (is_near) {
    for (const auto& part : parts_) {
      if (!part->is_moving() && !part->near().collect(part->in_part_frame(proxy_), distance, turn)) return 0.0;
    }
    if (!find_push(motion)) return 0.0;
    share = find_safe_share(motion);
  }
  const Placement to = motion.at(share);
  for (const auto& part : parts_) part->advance(motion, share, to);
  if (motion.length(radius()) > 0.0) proxy_ = to;
  return share;
}

void ToolProxy::carry(std::size_t first, std::size_t last, ToolProxyStep& report) noexcept {
  double budget = 2.0 * travel_ + kCatchUp * kOffset;
  double limit = budget;
  for (int k = 0; k < kMaxCarries; ++k) {
    double remaining = 0.0;
    double turn = 0.0;
    bool is_arrived = true;
    for (std::size_t p = first; p < last; ++p) {
      const ScenePart& part = *parts_[p];
      if (part.is_arrived()) continue;
      is_arrived = false;
      remaining = std::max(remaining, relative_travel_bound(proxy_, radius(), part.at(), part.target()));
      turn = std::max(turn, turn_between(part.at().orientation, part.target().orientation).norm());
    }
    if (is_arrived) return;
    double share = 1.0;
    if (remaining > std::min(limit, budget)) share = std::min(limit, budget) / remaining;
    if (turn > kLargestTurn) share = std::min(share, kLargestTurn / turn);
    const double length = share * remaining;
    if (share < 1.0 && length <= kConverged * kOffset) return;
    for (std::size_t p = first; p < last; ++p) parts_[p]->aim(share);
    ++report.carries;
    const double share_made = carry_round(length);
    for (const auto& part : parts_) part->stay();
    budget -= share_made * length;
    limit = share_made >= 1.0 || share_made * length >= kConverged * kOffset ? 4.0 * length : 0.25 * length;
  }
}

// Computes without the contacts' curvature, which belongs to the motion towards the device, not to the motion out of the parts' way.
void ToolProxy::carry_all(ToolProxyStep& report) noexcept {
  const auto is_there = [](const auto& part) { return part->is_arrived(); };
  if (std::all_of(parts_.begin(), parts_.end(), is_there)) return;
  const MotionEnergy energy = energy_;
  energy_.set_plain();
  carry(1, parts_.size(), report);
  // What keeps one part back need not keep back the others.
  for (std::size_t p = 1; p < parts_.size() && parts_.size() > 2; ++p) carry(p, p + 1, report);
  report.is_squeezed = !std::all_of(parts_.begin(), parts_.end(), is_there);
  energy_ = energy;
}

ToolProxyStep ToolProxy::step(const Placement& device, std::span<const Placement> parts) noexcept {
  ToolProxyStep report;
  if (!parts.empty()) set_targets(parts);
  if (is_blocked_) place(device);
  if (is_blocked_) {
    report.is_blocked = true;
    return report;
  }
  if (parts_.size() > 1) carry_all(report);
  // In contact the proxy moves about as far as in the step before, and mostly less than the device.
  reach_ = 1.5 * motion_between(last_proxy_, proxy_).length(radius()) + 16.0 * kOffset;
  if (contacts_.count == 0) reach_ = std::max(reach_, motion_between(proxy_, device).length(radius()));
  searched_length_ = reach_;
  last_proxy_ = proxy_;
  progress_.restart();
  follows_ = false;
  while (report.rounds < kMaxRounds) {
    ++report.rounds;
    report.converged = true;
    if (!round(device, report)) break;
  }
  report.is_frozen =
      report.is_frozen && proxy_.position == last_proxy_.position && proxy_.orientation.coeffs() == last_proxy_.orientation.coeffs();
  return report;
}

}  // namespace hapton
