#include "safety/safety_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {
namespace {

// A limit outside this range is probably in a wrong unit, and results computed with it could not be trusted.
bool is_usable(double limit) { return limit > kMinUsableLimit && limit < 1e9; }

// The slew rate, or more if needed to bring `most` to zero within kLongestReleaseNs.
double release_rate(double slew, double most) {
  return std::max(is_usable(slew) ? slew : 0.0, most / (1e-9 * static_cast<double>(kLongestReleaseNs)));
}

DeviceLimits sanitized(DeviceLimits limits) {
  constexpr double kNoEnd = std::numeric_limits<double>::infinity();
  const bool is_force_usable = is_usable(limits.max_force_n) && is_usable(limits.max_slew_n_per_s);
  limits.max_force_n = is_force_usable ? limits.max_force_n : 0.0;
  limits.max_slew_n_per_s = is_force_usable ? release_rate(limits.max_slew_n_per_s, limits.max_force_n) : 0.0;
  limits.max_torque_nm = is_force_usable && is_usable(limits.max_torque_nm) ? limits.max_torque_nm : 0.0;
  limits.max_torque_slew_nm_per_s = release_rate(limits.max_torque_slew_nm_per_s, limits.max_torque_nm);
  if (!is_usable(limits.max_stiffness_n_per_m)) limits.max_stiffness_n_per_m = 0.0;
  limits.continuous_force_n =
      is_usable(limits.continuous_force_n) ? std::min(limits.continuous_force_n, limits.max_force_n) : limits.max_force_n;
  if (!is_usable(limits.peak_s)) limits.peak_s = 0.0;
  if (!is_usable(limits.max_speed_m_per_s)) limits.max_speed_m_per_s = kFastestHandMPerS;
  for (int axis = 0; axis < 3; ++axis) {
    double& low = limits.workspace_min_m[axis];
    double& high = limits.workspace_max_m[axis];
    if (std::isfinite(low) && std::isfinite(high) && low < high) continue;
    low = -kNoEnd;
    high = kNoEnd;
  }
  return limits;
}

void lower(double& limit, double to) {
  if (is_usable(to)) limit = std::min(limit, to);
}

}  // namespace

SafetyLimits::SafetyLimits(const DeviceLimits& device) : device_(sanitized(device)), current_(device_) {}

void SafetyLimits::tighten(const DeviceLimits& wanted) noexcept {
  lower(current_.max_force_n, wanted.max_force_n);
  lower(current_.max_slew_n_per_s, wanted.max_slew_n_per_s);
  lower(current_.max_torque_nm, wanted.max_torque_nm);
  lower(current_.max_torque_slew_nm_per_s, wanted.max_torque_slew_nm_per_s);
  lower(current_.continuous_force_n, wanted.continuous_force_n);
  lower(current_.max_speed_m_per_s, wanted.max_speed_m_per_s);
  for (int axis = 0; axis < 3; ++axis) {
    // The wanted value first: std::max and std::min then return it if it is NaN, and the comparison below rejects it.
    const double low = std::max(wanted.workspace_min_m[axis], current_.workspace_min_m[axis]);
    const double high = std::min(wanted.workspace_max_m[axis], current_.workspace_max_m[axis]);
    if (!(low < high)) continue;
    current_.workspace_min_m[axis] = low;
    current_.workspace_max_m[axis] = high;
  }
}

void SafetyLimits::forbid_force() noexcept {
  current_.max_force_n = 0.0;
  current_.continuous_force_n = 0.0;
  forbid_torque();
}

void SafetyLimits::forbid_torque() noexcept { current_.max_torque_nm = 0.0; }

}  // namespace hapton
