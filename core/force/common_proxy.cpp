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
// A part whose device point has moved by less than this goes on as it is: of the largest share, of the coordinates, whose rounding is
// 2^-53, and of the lift.
constexpr double kAgree = 0x1p-26;
constexpr double kRounding = 0x1p-46;
constexpr double kAgreeLifts = 0.25;
// A share this many times as long as the whole, and this many lifts: two parts hold the proxy against each other without end. Two planes
// at 14 degrees have one of eight times.
constexpr double kMostShare = 8.0;
constexpr double kMostLifts = 64.0;

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
      part.lift.setZero();
    }
    if (start) felt.reset(i, *start);
    part.held = part.X_SO.linear() * part.held_O;
    part.begins_again = false;
    part.p_SP = part.X_SO * part.p_OP;
    part.start = part.p_SP - part.lift;
    part.was_held = !part.held.isZero(0.0);
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

// Returns whether the part was felt: its device point is another one than the last time in this sample.
bool CommonProxy::visit(FeltParts& felt, std::size_t i) noexcept {
  Part& part = parts_[i];
  const Vec3 lift = lift_of(i);
  const Vec3 follow = common_ + part.held + lift;
  const double agree = std::max(kAgree * largest_m_ + kRounding * follow.cwiseAbs().maxCoeff(), kAgreeLifts * lift_m_);
  if (part.is_felt && !part.begins_again && (follow - part.followed).norm() <= agree) return false;
  part.output = felt.feel(i, follow, {.is_correction = part.is_felt, .is_shared = is_shared_});
  part.is_felt = true;
  part.begins_again = false;
  part.followed = follow;
  part.lift = lift;
  part.p_SP = part.output.p_SP;
  part.held = follow - part.p_SP;
  common_ = part.p_SP - lift;
  return true;
}

void CommonProxy::begin_round(const Vec3& p_SD) noexcept {
  common_ = p_SD;
  largest_m_ = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    common_ -= parts_[i].held;
    largest_m_ = std::max(largest_m_, parts_[i].held.norm());
  }
  is_shared_ = held_count() > 1;
}

// A part has come into contact in this sample, and another one was in contact before it, or is now.
bool CommonProxy::has_met_another() const noexcept {
  bool is_new = false;
  int touched = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const bool is_held = !parts_[i].held.isZero(0.0);
    is_new = is_new || (is_held && !parts_[i].was_held);
    touched += is_held || parts_[i].was_held ? 1 : 0;
  }
  return is_new && touched > 1;
}

// One part has followed the hand without what the other holds. Each goes on from where it was before the sample, lifted off the others.
void CommonProxy::begin_again(FeltParts& felt) noexcept {
  is_shared_ = true;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (part.held.isZero(0.0) && !part.was_held) continue;
    part.was_held = true;
    part.begins_again = felt.resume(i, part.X_SO * part.p_OP);
    if (part.begins_again) (void)felt.feel(i, part.start + lift_of(i), {.is_correction = true, .is_shared = true});
  }
}

void CommonProxy::follow(FeltParts& felt, const Vec3& p_SD) noexcept {
  for (int round = 0; round < kRounds; ++round) {
    begin_round(p_SD);
    bool any = false;
    for (std::size_t i = 0; i < count_; ++i) any = visit(felt, i) || any;
    if (!any) return;
    const bool has_met = has_met_another();
    if (has_met) begin_again(felt);
    if ((has_met || round == 0) && held_count() > 1) share_out(p_SD);
  }
  if (has_still_) (void)visit(felt, 0);
}

// There is no nearest point that all allow, and shares have grown in vain. The proxy is where what stands still has it, or else the first
// part that holds it, and that holds it alone. Its force has the mean stiffness of all that do.
void CommonProxy::settle_squeezed(const Vec3& p_SD) noexcept {
  double shares = 0.0;
  double forces_n = 0.0;
  Part* holding = nullptr;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    if (part.held.isZero(0.0)) continue;
    if (holding == nullptr) holding = &part;
    shares += part.held.norm();
    forces_n += part.output.force_n.norm();
  }
  if (holding == nullptr) return;
  common_ = holding->p_SP - holding->lift;
  for (std::size_t i = 0; i < count_; ++i) {
    parts_[i].held.setZero();
    parts_[i].output.force_n.setZero();
  }
  holding->held = p_SD - common_;
  holding->output.force_n = -(forces_n / shares) * holding->held;
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
  follow(felt, p_SD);
  begin_round(p_SD);
  is_squeezed_ = largest_m_ > kMostShare * (p_SD - common_).norm() + kMostLifts * lift_m_;
  if (is_squeezed_) settle_squeezed(p_SD);
  return sum(p_SD);
}

}  // namespace hapton
