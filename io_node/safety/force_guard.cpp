#include "io_node/safety/force_guard.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

bool usable(double limit) { return std::isfinite(limit) && limit > 0.0; }

// Rounding must not lift a result over its limit.
constexpr double kBelow = 1.0 - 1e-12;

// v made no longer than length; exact for components whose squares overflow.
Vec3 shortened(const Vec3& v, double length, bool& cut) {
  const double largest = v.cwiseAbs().maxCoeff();
  cut = false;
  if (largest == 0.0) return v;
  const double norm = largest * (v / largest).norm();
  if (norm <= length) return v;
  cut = true;
  return (v / largest).normalized() * (length * kBelow);
}

}  // namespace

ForceGuard::ForceGuard(const ForceLimits& device) {
  if (!usable(device.max_force_n) || !usable(device.max_slew_n_per_s)) return;
  limits_ = device;
  limits_.max_slew_n_per_s = std::max(limits_.max_slew_n_per_s, limits_.max_force_n / (1e-9 * static_cast<double>(kLongestReleaseNs)));
  release_n_per_s_ = limits_.max_slew_n_per_s;
}

void ForceGuard::tighten(const ForceLimits& limits) noexcept {
  if (usable(limits.max_force_n)) limits_.max_force_n = std::min(limits_.max_force_n, limits.max_force_n);
  if (usable(limits.max_slew_n_per_s)) limits_.max_slew_n_per_s = std::min(limits_.max_slew_n_per_s, limits.max_slew_n_per_s);
}

void ForceGuard::let_go() noexcept {
  live_ = false;
  wanted_n_ = Vec3::Zero();
}

Vec3 ForceGuard::clamped(const Vec3& force_n) noexcept {
  bool cut = false;
  const Vec3 result = shortened(force_n, limits_.max_force_n, cut);
  if (cut) ++counters_.clamped;
  return result;
}

bool ForceGuard::accept(const WantedForce& wanted) noexcept {
  if (!wanted.force_n.allFinite()) {
    ++counters_.not_finite;
    let_go();
    return false;
  }
  if (wanted.sample_time_ns > now_ns_) {
    ++counters_.refused_future;
    return false;
  }
  const bool repeated = answered_ && wanted.sample_time_ns <= answered_ns_;
  if (repeated || wanted.sample_time_ns < now_ns_ - kSilenceLimitNs) {
    ++counters_.refused_old;
    return false;
  }
  ++counters_.accepted;
  if (!live_) ramp_begin_ns_ = now_ns_;
  live_ = answered_ = true;
  answered_ns_ = wanted.sample_time_ns;
  accepted_ns_ = now_ns_;
  wanted_n_ = clamped(wanted.force_n);
  return true;
}

Vec3 ForceGuard::target() noexcept {
  if (!live_) return Vec3::Zero();
  const double ramp = std::min(1.0, static_cast<double>(now_ns_ - ramp_begin_ns_) / static_cast<double>(kRampNs));
  const double left_s = 1e-9 * static_cast<double>(kSilenceLimitNs - (now_ns_ - accepted_ns_));
  bool cut = false;
  return shortened(ramp * wanted_n_, std::min(limits_.max_force_n, release_n_per_s_ * left_s), cut);
}

Vec3 ForceGuard::step(const std::optional<WantedForce>& wanted, std::int64_t now_ns) noexcept {
  if (!began_) now_ns_ = now_ns;
  began_ = true;
  const double passed_s = std::max(0.0, 1e-9 * (static_cast<double>(now_ns) - static_cast<double>(now_ns_)));
  now_ns_ = std::max(now_ns_, now_ns);
  if (live_ && now_ns_ - accepted_ns_ >= kSilenceLimitNs) {
    ++counters_.silences;
    let_go();
  }
  const bool accepted = wanted && accept(*wanted);
  const bool sinking = !live_ || now_ns_ - accepted_ns_ > kSilenceLimitNs - kLongestReleaseNs;
  const double reach_n = (sinking ? release_n_per_s_ : limits_.max_slew_n_per_s) * passed_s;
  bool cut = false;
  const Vec3 goal_n = target();
  const Vec3 change = shortened(goal_n - out_n_, reach_n, cut);
  // Within rounding of the goal is at the goal: zero means zero.
  out_n_ = cut && (goal_n - out_n_).norm() > reach_n / kBelow ? Vec3(out_n_ + change) : goal_n;
  if (cut && accepted) ++counters_.slewed;
  out_n_ = shortened(out_n_, limits_.max_force_n, cut);
  return out_n_;
}

}  // namespace hapton
