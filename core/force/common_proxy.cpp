#include "core/force/common_proxy.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

namespace hapton {
namespace {

// Rounds through all parts in a sample. Two planes at an angle converge by its squared cosine in each, and the quadratic program makes that
// exact where the surfaces are planes; what is left converges over the next samples.
constexpr int kRounds = 6;
// Rounds after a new beginning.
constexpr int kRoundsAgain = 4;
// A part that would move by less than this has converged: of the largest share, and of the coordinates, whose rounding is 2^-53.
constexpr double kAgree = 0x1p-26;
constexpr double kRounding = 0x1p-46;
// A round that moves the parts by more than this share of the one before does not converge: two planes at less than 8 degrees do.
constexpr double kConverging = 0.98;

}  // namespace

CommonProxy::CommonProxy(std::size_t most, double extent_m) : parts_(most), planes_(most), plane_of_(most), lift_m_(kLift * extent_m) {}

void CommonProxy::go_on_from(const Vec3& p_S) noexcept {
  place_ = p_S;
  start_.reset();
  is_squeezed_ = false;
}

void CommonProxy::begin_sample(FeltParts& felt, const Vec3& p_SD) noexcept {
  const std::optional<Vec3> start = std::exchange(start_, std::nullopt);
  const std::optional<Vec3> place = start ? start : place_;
  place_.reset();
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    part.X_SO = felt.pose(i);
    if (place) {
      part.p_OP = part.X_SO.inverse(Eigen::Isometry) * *place;
      part.held_O.setZero();
    }
    if (start) felt.reset(i, *start);
    part.held = part.X_SO.linear() * part.held_O;
    part.p_SP = part.X_SO * part.p_OP;
    part.is_felt = false;
  }
  if (held_count() > 1) share_out(p_SD);
}

int CommonProxy::held_count() const noexcept {
  int held = 0;
  for (std::size_t i = 0; i < count_; ++i) held += parts_[i].held.isZero(0.0) ? 0 : 1;
  return held;
}

// The shares of the planes that hold the proxy, for a device there.
void CommonProxy::share_out(const Vec3& p_SD) noexcept {
  std::size_t planes = 0;
  const Vec3 origin = common_;
  for (std::size_t i = 0; i < count_; ++i) {
    const Part& part = parts_[i];
    const double length = part.held.norm();
    if (!(length > 0.0)) continue;
    const Vec3 normal = -part.held / length;
    planes_[planes] = {normal, normal.dot(part.p_SP - part.lift - origin)};
    plane_of_[planes++] = i;
  }
  const ConstrainedMotion held = constrain_motion(p_SD - origin, std::span(planes_).first(planes));
  if (!held.solved) return;
  for (std::size_t n = 0; n < planes; ++n) parts_[plane_of_[n]].held.setZero();
  for (int k = 0; k < held.active_count; ++k) {
    const auto n = static_cast<std::size_t>(held.active[static_cast<std::size_t>(k)]);
    parts_[plane_of_[n]].held = -held.multipliers[static_cast<std::size_t>(k)] * planes_[n].normal;
  }
}

// Away from everything else that holds the proxy.
Vec3 CommonProxy::lift_of(std::size_t i) const noexcept {
  Vec3 lift = Vec3::Zero();
  for (std::size_t j = 0; j < count_; ++j) {
    const double length = j != i ? parts_[j].held.norm() : 0.0;
    if (length > 0.0) lift -= (lift_m_ / length) * parts_[j].held;
  }
  return lift;
}

// Returns how far the device point of the part has moved since it was felt in this sample; 0: not at all, and nothing changes.
double CommonProxy::visit(FeltParts& felt, std::size_t i) noexcept {
  Part& part = parts_[i];
  const Vec3 lift = lift_of(i);
  const Vec3 follow = common_ + part.held + lift;
  const double moved = (follow - part.followed).norm();
  const double agree = kAgree * largest_m_ + kRounding * follow.cwiseAbs().maxCoeff();
  if (part.is_felt && moved <= agree) return 0.0;
  part.output = felt.feel(i, follow, part.is_felt);
  part.followed = follow;
  part.lift = lift;
  part.p_SP = part.output.contact ? part.output.p_SP : follow;
  part.held = part.output.contact ? Vec3(follow - part.p_SP) : Vec3(Vec3::Zero());
  common_ = part.p_SP - lift;
  return std::exchange(part.is_felt, true) ? moved : 0.0;
}

CommonProxy::Ended CommonProxy::follow(FeltParts& felt, const Vec3& p_SD, int rounds) noexcept {
  common_ = p_SD;
  for (std::size_t i = 0; i < count_; ++i) common_ -= parts_[i].held;
  double before = 0.0;
  double moved = 0.0;
  for (int round = 0; round < rounds; ++round) {
    before = moved;
    moved = 0.0;
    largest_m_ = 0.0;
    for (std::size_t i = 0; i < count_; ++i) largest_m_ = std::max(largest_m_, parts_[i].held.norm());
    for (std::size_t i = 0; i < count_; ++i) {
      const Vec3 at = common_;
      const double by = visit(felt, i);
      moved = std::max(moved, by);
      if (by > 0.0 && !(i == 0 && has_still_)) gap_ = at - parts_[i].p_SP + parts_[i].lift;
    }
    if (round > 0 && moved == 0.0) return Ended::converged;
    if (round == 0 && held_count() > 1) {
      share_out(p_SD);
      common_ = p_SD;
      for (std::size_t i = 0; i < count_; ++i) common_ -= parts_[i].held;
    }
  }
  if (has_still_) visit(felt, 0);
  return moved > kConverging * before && moved > lift_m_ ? Ended::squeezed : Ended::exhausted;
}

// All that hold the proxy but the first or the last of them go on from where they were before the sample, and know what that one holds.
CommonProxy::Ended CommonProxy::begin_again(FeltParts& felt, const Vec3& p_SD, bool from_first) noexcept {
  std::size_t kept = count_;
  for (std::size_t n = 0; n < count_ && kept == count_; ++n) {
    const std::size_t i = from_first ? n : count_ - 1 - n;
    if (!parts_[i].held.isZero(0.0)) kept = i;
  }
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (i == kept) {
      const Vec3 normal = -part.held.normalized();
      part.held = -std::max(0.0, normal.dot(part.p_SP - part.lift - p_SD)) * normal;
    } else if (!part.held.isZero(0.0)) {
      felt.resume(i, part.X_SO * part.p_OP);
      part.held.setZero();
    }
  }
  return follow(felt, p_SD, kRoundsAgain);
}

// There is no nearest point that all allow, and shares have grown in vain. What moves holds the proxy by as much as it would move it, what
// stands still by the rest.
void CommonProxy::settle_squeezed(const Vec3& p_SD) noexcept {
  Vec3 rest = p_SD - common_;
  const auto set_share = [](Part& part, const Vec3& held) {
    const double length = part.held.norm();
    part.output.force_n *= length > 0.0 ? held.norm() / length : 0.0;
    part.held = held;
  };
  for (std::size_t i = has_still_ ? 1 : 0; i < count_; ++i) {
    Part& part = parts_[i];
    const double length = part.held.norm();
    const double most = std::max(gap_.norm(), rest.norm());
    if (length > most) set_share(part, part.held * (most / length));
    rest -= part.held;
  }
  if (has_still_ && !parts_[0].held.isZero(0.0)) {
    const Vec3 normal = -parts_[0].held.normalized();
    set_share(parts_[0], -std::max(0.0, -normal.dot(rest)) * normal);
  }
}

MethodOutput CommonProxy::sum(const Vec3& p_SD) noexcept {
  MethodOutput output{.force_n = Vec3::Zero(), .p_SP = p_SD};
  double most_n = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    part.p_OP = part.X_SO.inverse(Eigen::Isometry) * part.p_SP;
    part.held_O = part.X_SO.linear().transpose() * part.held;
    if (!part.output.contact) continue;
    output.contact = true;
    output.p_SP = common_;
    output.force_n += part.output.force_n;
    if (const double pushes = part.output.force_n.norm(); part.output.object >= 0 && pushes >= most_n) {
      most_n = pushes;
      output.object = part.output.object;
    }
  }
  return output;
}

MethodOutput CommonProxy::step(FeltParts& felt, std::size_t count, bool has_still, const Vec3& p_SD) noexcept {
  count_ = count;
  has_still_ = has_still;
  begin_sample(felt, p_SD);
  Ended ended = follow(felt, p_SD, kRounds);
  // Where there was no room before, no new beginning helps.
  for (const bool from_first : {false, true}) {
    if (ended == Ended::squeezed && !is_squeezed_) ended = begin_again(felt, p_SD, from_first);
  }
  is_squeezed_ = ended == Ended::squeezed;
  if (is_squeezed_) settle_squeezed(p_SD);
  return sum(p_SD);
}

}  // namespace hapton
