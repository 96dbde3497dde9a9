#include "core/force/evaluation/force_error.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// Shares of the extent. Free choices, the same as those of hapton stress (stress_run.cpp).
constexpr double kFallThroughShare = 0.0025;
constexpr double kStuckShare = 0.10;
// A share of the force, or of that at the depth kFallThroughShare if it is larger. Twenty times the rounding of positions a million extents
// from the origin: that is 2^-33 of an extent, 5e-8 of kFallThroughShare.
constexpr double kJumpRounding = 0x1p-20;

bool is_finite(const ForceSample& step) { return step.force_n.allFinite() && step.proxy.allFinite(); }

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

bool starts_segment(std::size_t i, const ForceErrorSettings& settings) {
  return i == 0 || (settings.reset_every > 0 && i % settings.reset_every == 0);
}

double share_of(const ForceSample& method, const ForceSample& reference) {
  return (method.force_n - reference.force_n).norm() / reference.force_n.norm();
}

void add_to_switches(ForceError& error, std::size_t i, double share, bool continues, std::span<const ForceSample> reference,
                     std::span<const ForceSample> converged) {
  using Cause = BranchSwitch::Cause;
  const bool arrives = i < converged.size() && share_of(converged[i], reference[i]) <= ForceError::kBranchShare;
  if (!continues) {
    error.switches.push_back({.first_step = i, .cause = Cause::unconverged});
    ++error.branch_switches;
  }
  BranchSwitch& last = error.switches.back();
  if (!arrives) last.cause = reference[last.first_step].settled ? Cause::unexplained : Cause::unsettled;
  ++last.steps;
  last.most = std::max(last.most, share);
  ++error.switched_steps;
}

double jump(std::span<const ForceSample> steps, std::size_t i) { return (steps[i].force_n - steps[i - 1].force_n).norm(); }

}  // namespace

ErrorSpread spread_of(std::vector<double> values) {
  ErrorSpread spread;
  spread.count = values.size();
  if (values.empty()) return spread;
  std::sort(values.begin(), values.end());
  auto rank = [&](double share) {
    const double at = std::ceil(share * static_cast<double>(values.size())) - 1.0;
    return values[static_cast<std::size_t>(std::max(0.0, at))];
  };
  long double squares = 0.0L;
  for (const double value : values) squares += static_cast<long double>(value) * value;
  spread.rms = static_cast<double>(std::sqrt(squares / static_cast<long double>(values.size())));
  spread.p50 = rank(0.50);
  spread.p99 = rank(0.99);
  spread.most = values.back();
  return spread;
}

std::size_t ForceError::count(BranchSwitch::Cause cause) const {
  return static_cast<std::size_t>(std::count_if(switches.begin(), switches.end(), [&](const BranchSwitch& s) { return s.cause == cause; }));
}

ForceError compare_forces(std::span<const ForceSample> method, std::span<const ForceSample> reference, const ForceErrorSettings& settings,
                          std::span<const ForceSample> converged) {
  ForceError error;
  error.steps = std::min(method.size(), reference.size());
  const double stiffness = settings.stiffness_n_per_m;
  const double fall_through_depth = kFallThroughShare * settings.extent_m;
  std::vector<double> shares, directions;
  double worst = -1.0;
  bool is_in_switch = false;
  for (std::size_t i = 0; i < error.steps; ++i) {
    if (starts_segment(i, settings)) is_in_switch = false;
    if (!is_finite(method[i])) {
      ++error.not_finite;
      is_in_switch = false;
      continue;
    }
    const double actual = method[i].force_n.norm();
    const double expected = reference[i].force_n.norm();
    bool is_switched = false;
    if (expected > 0.0) {
      ++error.contact_steps;
      error.unsettled_steps += reference[i].settled ? 0 : 1;
      const double share = share_of(method[i], reference[i]);
      shares.push_back(share);
      if (actual > 0.0) directions.push_back(angle_between(method[i].force_n, reference[i].force_n));
      is_switched = share > ForceError::kBranchShare;
      if (is_switched) add_to_switches(error, i, share, is_in_switch, reference, converged);
      if (share > worst) {
        worst = share;
        error.worst_step = i;
      }
    }
    is_in_switch = is_switched;
    const double depth = (reference[i].proxy - reference[i].device).norm();
    const double extension = (method[i].proxy - method[i].device).norm();
    if (actual == 0.0 && depth > fall_through_depth) ++error.fall_throughs;
    if (expected == 0.0 && actual > 0.0 && extension > fall_through_depth) ++error.false_contacts;
    if (extension > depth + kStuckShare * settings.extent_m) ++error.stuck_steps;
    if (starts_segment(i, settings) || !is_finite(method[i - 1])) continue;
    double reference_jump = 0.0;
    for (std::size_t j = i - 1; j <= i + 1 && j < error.steps; ++j) {
      if (!starts_segment(j, settings)) reference_jump = std::max(reference_jump, jump(reference, j));
    }
    const double allowed = 2.0 * stiffness * (method[i].device - method[i - 1].device).norm() + reference_jump;
    const double above = jump(method, i) - allowed;
    if (above > kJumpRounding * std::max(actual, stiffness * fall_through_depth)) {
      ++error.discontinuities;
      error.worst_discontinuity_n = std::max(error.worst_discontinuity_n, above);
    }
  }
  error.error = spread_of(std::move(shares));
  error.direction_rad = spread_of(std::move(directions));
  return error;
}

}  // namespace hapton
