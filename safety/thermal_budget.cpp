#include "safety/thermal_budget.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

double squared(double x) { return x * x; }

}  // namespace

ThermalBudget::ThermalBudget(const DeviceLimits& device) {
  const bool has_budget = device.peak_s > 0.0 && device.continuous_force_n < device.max_force_n;
  if (has_budget) time_constant_s_ = -device.peak_s / std::log1p(-squared(device.continuous_force_n / device.max_force_n));
}

void ThermalBudget::note_applied(const Vec3& force_n, double passed_s) noexcept {
  if (time_constant_s_ == 0.0) return;
  const double x = std::min(passed_s, kLongestHeldS) / time_constant_s_;
  const double share = x < 1e-4 ? x - 0.5 * x * x : -std::expm1(-x);  // the series differs by less than 2e-13, and is faster
  heat_n2_ += (force_n.squaredNorm() - heat_n2_) * share;
}

double ThermalBudget::allowed_n(const DeviceLimits& limits) const noexcept {
  const double fade_share = (1.0 - load(limits)) / (1.0 - kFadeFrom);
  if (fade_share >= 1.0 || limits.continuous_force_n >= limits.max_force_n) return limits.max_force_n;
  const double continuous = squared(limits.continuous_force_n);
  return std::sqrt(continuous + (squared(limits.max_force_n) - continuous) * std::max(fade_share, 0.0));
}

}  // namespace hapton
