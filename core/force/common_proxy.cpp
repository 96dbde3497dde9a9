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
  holding_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    Part& part = parts_[i];
    part.X_before = part.X_SO;
    part.X_SO = felt.pose(i);
    part.p_before = part.p_SP;
    part.lift_before = part.lift;
    part.is_felt = part.begins_again = false;
    if (place) {
      part.X_before = part.X_SO;
      part.p_before = *place;
      part.held.setZero();
      part.lift_before = part.lift = Vec3::Zero();
    }
    if (start) felt.reset(i, part.X_SO, *start);
    part.was_held = part.holds();
    if (!part.was_held) continue;
    ++holding_;
    part.held = part.X_SO.linear() * (part.X_before.linear().transpose() * part.held);
    part.p_SP = part.start();
  }
  if (holding_ > 1) share_out(p_SD);
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

// Feels the part, where its device point is another one than the last time in this sample. Returns whether that may matter to others: it
// holds the proxy, or did.
bool CommonProxy::visit(FeltParts& felt, std::size_t i) noexcept {
  Part& part = parts_[i];
  const Vec3 lift = holding_ > 0 ? lift_of(i) : Vec3(Vec3::Zero());
  const Vec3 follow = common_ + part.held + lift;
  if (part.is_felt && !part.begins_again) {
    const double agree = std::max(kAgree * largest_m_ + kRounding * follow.cwiseAbs().maxCoeff(), kAgreeLifts * lift_m_);
    if ((follow - part.followed).norm() <= agree) return false;
  }
  const bool held_before = part.holds();
  part.output = felt.feel(i, part.X_SO, follow, {.is_correction = part.is_felt, .is_shared = is_shared_});
  part.is_felt = true;
  part.begins_again = false;
  part.followed = follow;
  part.lift = lift;
  part.p_SP = part.output.p_SP;
  part.held = follow - part.p_SP;
  holding_ += static_cast<int>(part.holds()) - static_cast<int>(held_before);
  common_ = part.p_SP - lift;
  return held_before || part.holds();
}

void CommonProxy::begin_round(const Vec3& p_SD) noexcept {
  common_ = p_SD;
  largest_m_ = 0.0;
  holding_ = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!parts_[i].holds()) continue;
    ++holding_;
    common_ -= parts_[i].held;
    largest_m_ = std::max(largest_m_, parts_[i].held.norm());
  }
  is_shared_ = holding_ > 1;
}

// A part has come into contact in this sample, and another one was in contact before it, or is now.
bool CommonProxy::has_met_another() const noexcept {
  bool is_new = false;
  int touched = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Part& part = parts_[i];
    is_new = is_new || (part.holds() && !part.was_held);
    touched += part.holds() || part.was_held ? 1 : 0;
  }
  return is_new && touched > 1;
}

// One part has followed the hand without what the other holds. Each goes on from where it was before the sample, lifted off the others.
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

void CommonProxy::follow(FeltParts& felt, const Vec3& p_SD) noexcept {
  for (int round = 0; round < kRounds; ++round) {
    begin_round(p_SD);
    bool any = false;
    for (std::size_t i = 0; i < count_; ++i) any = visit(felt, i) || any;
    if (!any || (round == 0 && holding_ == 0)) return;
    const bool has_met = has_met_another();
    if (has_met) begin_again(felt);
    if ((has_met || round == 0) && holding_ > 1) share_out(p_SD);
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
  if (holding_ == 0) return {.force_n = Vec3::Zero(), .p_SP = p_SD};
  begin_round(p_SD);
  is_squeezed_ = largest_m_ > kMostShare * (p_SD - common_).norm() + kMostLifts * lift_m_;
  if (is_squeezed_) settle_squeezed(p_SD);
  return sum(p_SD);
}

}  // namespace hapton
