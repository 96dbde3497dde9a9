#include "core/force/common_proxy.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace hapton {
namespace {

// Rounds through all parts in a sample. With two planes, each round reduces the error by the squared cosine of their angle. Where the
// surfaces are planes, the quadratic program makes the result exact; an error that is left decreases over the next samples.
constexpr int kRounds = 6;
// The same without friction. A part that holds the proxy with another face than before, as in the sample in which a hand slides off an
// edge, changes the planes: then the program is solved again in every second round. With friction a part does not hold the proxy like a
// plane, and more rounds make the force less steady.
constexpr int kFrictionlessRounds = 12;
// A part takes no further step if its device point has moved by at most the larger of two distances: kToleranceInShares times the longest
// share plus kRounding times the coordinates (whose rounding is 2^-53), and kToleranceInLifts times the lift.
constexpr double kToleranceInShares = 0x1p-26;
constexpr double kRounding = 0x1p-46;
constexpr double kToleranceInLifts = 0.25;
// A share longer than kMaxShare times the whole (device minus proxy) plus kMaxLifts lifts: two parts hold the proxy against each other
// without end. Between two planes at 14 degrees, a share is eight times as long as the whole.
constexpr double kMaxShare = 8.0;
constexpr double kMaxLifts = 64.0;

}  // namespace

CommonProxy::CommonProxy(std::size_t max_parts, double extent_m, bool in_series)
    : parts_(max_parts),
      planes_(max_parts),
      part_of_plane_(max_parts),
      with_share_(max_parts),
      in_series_(in_series),
      lift_m_(kLift * extent_m) {}

void CommonProxy::go_on_from(const Vec3& p_S) noexcept {
  continue_from_ = p_S;
  reset_to_.reset();
}

void CommonProxy::forget() noexcept {
  for (Part& part : parts_) part = {};
  reset_to_.reset();
  continue_from_.reset();
  has_sample_ = false;
}

void CommonProxy::begin_sample(FeltParts& felt) noexcept {
  const std::optional<Vec3> start = std::exchange(reset_to_, std::nullopt);
  const std::optional<Vec3> place = start ? start : continue_from_;
  continue_from_.reset();
  if (place) p_SD_before_.reset();
  holding_count_ = 0;
  const bool any_gives_way = !in_series_ && felt.may_give_way();
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    part.X_before = part.X_SO;
    part.X_SO = felt.pose(i);
    part.p_before = part.p_SP;
    part.lift_before = part.lift;
    part.is_felt = part.begins_again = false;
    part.turns = 0;
    part.was_with_others = part.with_others && !place;
    if (place) {
      part.X_before = part.X_SO;
      part.p_before = *place;
      part.share = part.lift = part.lift_before = Vec3::Zero();
      part.is_limited = false;
    }
    if (start) felt.reset(i, part.X_SO, *start);
    part.gives_way = any_gives_way && felt.gives_way(i);
    if (part.gives_way) {
      part.share.setZero();
      part.is_limited = false;
    }
    part.was_held = part.holds();
    if (!part.was_held) continue;
    ++holding_count_;
    part.share = part.X_SO.linear() * (part.X_before.linear().transpose() * part.share);
    part.p_SP = part.start();
  }
  goal_ = p_SD_;
  is_goal_displaced_ = false;
  if (any_gives_way) feel_parts_giving_way(felt);
  if (holding_count_ > 1) share_out();
}

// Each of several parts that give way follows the one before it.
void CommonProxy::feel_parts_giving_way(FeltParts& felt) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (!part.gives_way) continue;
    part.output = felt.feel(i, part.X_SO, goal_, {});
    part.is_felt = true;
    part.share = goal_ - part.output.p_SP;
    is_goal_displaced_ = is_goal_displaced_ || !part.share.isZero(0.0);
    goal_ = part.output.p_SP;
  }
}

// The largest length of a share of any part but the first that holds the proxy. whole_m: from the proxy to the device.
double CommonProxy::limit_m(double whole_m) const noexcept { return kMaxShare * whole_m + kMaxLifts * lift_m_; }

// Replaces the shares by those that the planes holding the proxy have in the quadratic program, if none of these is too long.
void CommonProxy::share_out() noexcept {
  std::size_t planes = 0;
  const Vec3 origin = p_SP_;
  for (std::size_t i = 0; i < count_; ++i) {
    const Part& part = parts_[i];
    const double length = part.share.norm();
    if (part.gives_way || !(length > 0.0)) continue;
    const Vec3 normal = -part.share / length;
    planes_[planes] = {normal, normal.dot(part.p_SP - part.lift - origin)};
    part_of_plane_[planes++] = i;
  }
  const ConstrainedMotion constrained = constrain_motion(goal_ - origin, std::span(planes_).first(planes));
  if (!constrained.solved) return;
  const double most_m = limit_m((constrained.motion - (goal_ - origin)).norm());
  for (std::size_t k = 0; k < 3; ++k) {
    if (constrained.active[k] > 0 && constrained.multipliers[k] > most_m) return;
  }
  for (std::size_t n = 0; n < planes; ++n) parts_[part_of_plane_[n]].share.setZero();
  for (int k = 0; k < constrained.active_count; ++k) {
    const auto n = static_cast<std::size_t>(constrained.active[static_cast<std::size_t>(k)]);
    parts_[part_of_plane_[n]].share = -constrained.multipliers[static_cast<std::size_t>(k)] * planes_[n].normal;
  }
}

// The lift of part i, away from every other part that holds the proxy: these are few, however many parts there are.
Vec3 CommonProxy::lift_of(std::size_t i) const noexcept {
  Vec3 lift = Vec3::Zero();
  for (std::size_t n = 0; n < with_share_count_; ++n) {
    const std::size_t j = with_share_[n];
    const double length = j != i ? parts_[j].share.norm() : 0.0;
    if (length > 0.0) lift -= (lift_m_ / length) * parts_[j].share;
  }
  return lift;
}

// Notes a part that has got a share since the round began. The list is in order: the last bit of the sum in lift_of depends on it.
void CommonProxy::note_share(std::size_t i) noexcept {
  std::size_t n = with_share_count_;
  while (n > 0 && with_share_[n - 1] > i) --n;
  if (n > 0 && with_share_[n - 1] == i) return;
  std::move_backward(with_share_.begin() + static_cast<std::ptrdiff_t>(n),
                     with_share_.begin() + static_cast<std::ptrdiff_t>(with_share_count_),
                     with_share_.begin() + static_cast<std::ptrdiff_t>(with_share_count_ + 1));
  with_share_[n] = i;
  ++with_share_count_;
}

// Feels the part, unless its device point is the same as when the part was last felt in this sample. Returns whether that may matter to
// others: the part holds the proxy, or did before.
bool CommonProxy::visit(FeltParts& felt, std::size_t i) noexcept {
  Part& part = parts_[i];
  const Vec3 lift = holding_count_ > 0 ? lift_of(i) : Vec3(Vec3::Zero());
  const Vec3 follow = p_SP_ + part.share + lift;
  if (part.is_felt && !part.begins_again) {
    if (part.turns >= felt.most_turns(i)) return false;
    const double tolerance =
        std::max(kToleranceInShares * longest_share_m_ + kRounding * follow.cwiseAbs().maxCoeff(), kToleranceInLifts * lift_m_);
    if ((follow - part.followed_point).norm() <= tolerance) return false;
  }
  const bool held_before = part.holds();
  // If others held the proxy only in the last sample, the change of their shares would look like motion of the device as well.
  part.with_others = is_shared_;
  part.is_shared = is_shared_ || part.was_with_others;
  part.output = felt.feel(i, part.X_SO, follow, {.is_correction = part.is_felt, .is_shared = part.is_shared});
  part.is_felt = true;
  ++part.turns;
  part.begins_again = false;
  part.followed_point = follow;
  part.lift = lift;
  part.p_SP = part.output.p_SP;
  part.share = follow - part.p_SP;
  if (!part.share.isZero(0.0)) note_share(i);
  part.is_limited = false;
  holding_count_ += static_cast<int>(part.holds()) - static_cast<int>(held_before);
  const Vec3 before = p_SP_;
  p_SP_ = part.p_SP - lift;
  if (holding_count_ > 1 && first_holding() < i) limit_share(part, std::max((goal_ - before).norm(), (goal_ - p_SP_).norm()));
  return held_before || part.holds();
}

std::size_t CommonProxy::first_holding() const noexcept {
  std::size_t n = 0;
  while (n < with_share_count_ && !parts_[with_share_[n]].holds()) ++n;
  return n < with_share_count_ ? with_share_[n] : count_;
}

void CommonProxy::limit_share(Part& part, double whole_m) noexcept {
  const double most_m = limit_m(whole_m);
  const double length_m = part.share.norm();
  if (!(length_m > most_m)) return;
  part.share *= most_m / length_m;
  part.output.force_n *= most_m / length_m;
  p_SP_ = part.followed_point - part.lift - part.share;
  part.is_limited = true;
}

void CommonProxy::begin_round() noexcept {
  p_SP_ = goal_;
  longest_share_m_ = 0.0;
  holding_count_ = 0;
  with_share_count_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!parts_[i].share.isZero(0.0)) with_share_[with_share_count_++] = i;
    if (!parts_[i].holds()) continue;
    ++holding_count_;
    p_SP_ -= parts_[i].share;
    longest_share_m_ = std::max(longest_share_m_, parts_[i].share.norm());
  }
  is_shared_ = holding_count_ > 1 || (holding_count_ > 0 && is_goal_displaced_);
}

// Whether a part has come into contact in this sample, and another part is in contact now or was before the sample.
bool CommonProxy::has_second_contact() const noexcept {
  bool is_new = false;
  int touched = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Part& part = parts_[i];
    is_new = is_new || (part.holds() && !part.was_held);
    touched += part.holds() || part.was_held ? 1 : 0;
  }
  return is_new && touched > 1;
}

// One part has followed the hand without the share of another. Each begins again where it was before the sample, lifted off the others.
void CommonProxy::begin_again(FeltParts& felt) noexcept {
  is_shared_ = true;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (!part.holds() && !part.was_held) continue;
    part.was_held = true;
    const Vec3 start = part.start();
    part.begins_again = felt.resume(i, part.X_SO, start);
    if (!part.begins_again) continue;
    (void)felt.feel(i, part.X_SO, start - part.lift_before + lift_of(i), {.is_correction = true, .is_shared = true});
  }
}

// Whether each part that holds the proxy has no friction and may have another turn in this sample.
bool CommonProxy::allows_more_rounds(const FeltParts& felt) const noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if (parts_[i].holds() && (!felt.is_frictionless(i) || parts_[i].turns >= felt.most_turns(i))) return false;
  }
  return true;
}

void CommonProxy::follow(FeltParts& felt) noexcept {
  bool any_changed = true;
  const auto goes_on = [&](int round) { return round < kRounds || (round < kFrictionlessRounds && allows_more_rounds(felt)); };
  for (int round = 0; any_changed && goes_on(round); ++round) {
    begin_round();
    any_changed = false;
    for (std::size_t i = 0; i < count_; ++i) any_changed = (!parts_[i].gives_way && visit(felt, i)) || any_changed;
    if (!any_changed) break;
    const bool has_second = has_second_contact();
    if (has_second) begin_again(felt);
    if (holding_count_ > 1 && (has_second || round == 0 || (round % 2 == 0 && allows_more_rounds(felt)))) share_out();
  }
  is_squeezed_ = std::ranges::any_of(std::span(parts_).first(count_), &Part::is_limited);
  const std::size_t first = has_still_ ? 0 : first_holding();
  if (any_changed && first < count_ && !parts_[first].gives_way && (has_still_ || is_squeezed_)) (void)visit(felt, first);
}

void CommonProxy::follow_in_series(FeltParts& felt) noexcept {
  for (std::size_t i = 0; i < count_; ++i) parts_[i].share.setZero();
  begin_round();
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    part.output = felt.feel(i, part.X_SO, p_SP_, {});
    part.share = p_SP_ - part.output.p_SP;
    p_SP_ = part.p_SP = part.output.p_SP;
    holding_count_ += part.holds() ? 1 : 0;
  }
}

// Divides the shares as between surfaces: parts that do not give way have had only a small part of their share against a surface.
void CommonProxy::share_with_parts_giving_way(const FeltParts& felt) noexcept {
  const Vec3 whole = p_SD_ - p_SP_;
  const Vec3 sum_of_shares = goal_ - p_SP_;
  const double squared = sum_of_shares.squaredNorm();
  const double factor = squared > 0.0 ? std::max(1.0, whole.dot(sum_of_shares) / squared) : 1.0;
  double giving_way_m = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (part.gives_way) {
      giving_way_m += part.share.norm();
    } else {
      part.share *= factor;
      part.output.force_n *= factor;
    }
  }
  const Vec3 remainder = whole - factor * sum_of_shares;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (!part.gives_way || !(giving_way_m > 0.0)) continue;
    part.share = (part.share.norm() / giving_way_m) * remainder;
    part.output.force_n = -felt.stiffness(i).least * part.share;
    part.is_shared = true;
  }
}

// The mean over all parts that hold the proxy, weighted by their shares. It is updated by differences: equal values have an exact mean.
double CommonProxy::find_mean_stiffness(const FeltParts& felt) noexcept {
  double mean = 0.0;
  double shares_m = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    const double share_m = part.share.norm();
    if (!(share_m > 0.0) || !part.output.contact) continue;
    const StiffnessRange range = felt.stiffness(i);
    part.stiffness = std::clamp(part.output.force_n.norm() / share_m, range.least, range.most);
    shares_m += share_m;
    mean += (share_m / shares_m) * (part.stiffness - mean);
  }
  return mean;
}

// The velocity of the device relative to the part.
Vec3 CommonProxy::velocity_relative_to(const Part& part) const noexcept {
  if (!p_SD_before_ || !(dt_s_ > 0.0)) return Vec3::Zero();
  return (p_SD_ - part.X_SO * (part.X_before.inverse(Eigen::Isometry) * *p_SD_before_)) / dt_s_;
}

// The force of a part, with the mean stiffness in place of its own. Damping never makes it attractive.
Vec3 CommonProxy::force_with(const Part& part, double stiffness, double damping) const noexcept {
  const double force_n = part.output.force_n.norm();
  const double share_m = part.share.norm();
  if (!(share_m > 0.0)) return part.output.force_n;
  const double drag_n = damping > 0.0 ? damping * velocity_relative_to(part).dot(part.share) / share_m : 0.0;
  const double more_n = (stiffness - part.stiffness) * share_m + drag_n;
  if (more_n == 0.0) return part.output.force_n;
  const Vec3 direction = force_n > 0.0 ? Vec3(part.output.force_n / force_n) : Vec3(-part.share / share_m);
  return std::max(0.0, force_n + more_n) * direction;
}

MethodOutput CommonProxy::sum(const FeltParts& felt) noexcept {
  MethodOutput output{.force_n = Vec3::Zero(), .p_SP = p_SD_};
  const double stiffness = is_shared_ ? find_mean_stiffness(felt) : 0.0;
  double most_n = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (!part.output.contact) continue;
    output.contact = true;
    output.p_SP = p_SP_;
    const double damping = part.is_shared && part.output.object >= 0 ? felt.damping(i, part.output.object) : 0.0;
    part.force_n = is_shared_ || damping > 0.0 ? force_with(part, is_shared_ ? stiffness : part.stiffness, damping) : part.output.force_n;
    output.force_n += part.force_n;
    if (const double pushes = part.force_n.norm(); part.output.object >= 0 && pushes >= most_n) {
      most_n = pushes;
      output.object = part.output.object;
    }
  }
  return output;
}

MethodOutput CommonProxy::conclude(FeltParts& felt) noexcept {
  begin_round();
  if (is_goal_displaced_) {
    for (std::size_t i = 0; i < count_; ++i) {
      Part& part = parts_[i];
      part.is_shared = part.is_shared && !part.gives_way;
      if (!part.gives_way) continue;
      felt.settle(i, p_SP_);
      part.p_SP = p_SP_;
    }
    if (holding_count_ > 0) share_with_parts_giving_way(felt);
  }
  return sum(felt);
}

MethodOutput CommonProxy::step(FeltParts& felt, std::size_t count, bool has_still, const Vec3& p_SD, double dt_s) noexcept {
  dt_s_ = dt_s;
  p_SD_before_ = has_sample_ ? std::optional(p_SD_) : std::nullopt;
  has_sample_ = true;
  count_ = count;
  has_still_ = has_still;
  p_SD_ = p_SD;
  begin_sample(felt);
  if (in_series_) {
    follow_in_series(felt);
    return sum(felt);
  }
  follow(felt);
  if (holding_count_ == 0 && !is_goal_displaced_) return {.force_n = Vec3::Zero(), .p_SP = p_SD};
  return conclude(felt);
}

}  // namespace hapton
