#include "core/force/force_error.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

constexpr double kBasinShare = 0.01;
constexpr double kFallShare = 0.0025;
constexpr double kLockShare = 0.10;

bool is_finite(const FeltStep& step) { return step.force_n.allFinite() && step.proxy.allFinite(); }

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

bool starts_segment(std::size_t i, const ForceErrorSettings& settings) {
  return i == 0 || (settings.reset_every > 0 && i % settings.reset_every == 0);
}

bool references_differ(const FeltStep& coarse, const FeltStep& fine) {
  return (coarse.force_n - fine.force_n).norm() > kBasinShare * std::max(coarse.force_n.norm(), fine.force_n.norm());
}

double jump(std::span<const FeltStep> steps, std::size_t i) { return (steps[i].force_n - steps[i - 1].force_n).norm(); }

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

ForceError compare_forces(std::span<const FeltStep> method, std::span<const FeltStep> reference, std::span<const FeltStep> finer_reference,
                          const ForceErrorSettings& settings) {
  ForceError error;
  error.steps = std::min({method.size(), reference.size(), finer_reference.size()});
  const double k = settings.stiffness_n_per_m;
  std::vector<std::uint8_t> basin(error.steps, 0);
  for (std::size_t i = 0; i < error.steps; ++i) {
    if (references_differ(reference[i], finer_reference[i])) basin[i] = 1;
  }
  std::vector<double> all, away, direction;
  double worst = -1.0;
  for (std::size_t i = 0; i < error.steps; ++i) {
    if (!is_finite(method[i])) {
      ++error.not_finite;
      continue;
    }
    const double felt = method[i].force_n.norm();
    const double expected = finer_reference[i].force_n.norm();
    const double deep = kFallShare * settings.extent_m;
    if (expected > 0.0) {
      ++error.contact_steps;
      const double share = (method[i].force_n - finer_reference[i].force_n).norm() / expected;
      all.push_back(share);
      if (basin[i] != 0) {
        ++error.basin_steps;
      } else {
        away.push_back(share);
        if (felt > 0.0) direction.push_back(angle_between(method[i].force_n, finer_reference[i].force_n));
        if (share > worst) {
          worst = share;
          error.worst_step = i;
        }
      }
    }
    const double depth = (finer_reference[i].proxy - finer_reference[i].device).norm();
    const double stretch = (method[i].proxy - method[i].device).norm();
    if (felt == 0.0 && depth > deep && reference[i].force_n.norm() > 0.0) ++error.falls;
    if (expected == 0.0 && reference[i].force_n.norm() == 0.0 && felt > 0.0 && stretch > deep) ++error.ghosts;
    if (basin[i] == 0 && stretch > depth + kLockShare * settings.extent_m) ++error.locks;
    if (starts_segment(i, settings) || !is_finite(method[i - 1])) continue;
    double allowed = 2.0 * k * (method[i].device - method[i - 1].device).norm();
    double own = 0.0;
    for (std::size_t j = i - 1; j <= i + 1 && j < error.steps; ++j) {
      if (!starts_segment(j, settings)) own = std::max({own, jump(reference, j), jump(finer_reference, j)});
    }
    allowed += own;
    const double above = jump(method, i) - allowed;
    if (above > 1e-6 * std::max(felt, k * deep)) {
      ++error.pops;
      error.worst_pop_n = std::max(error.worst_pop_n, above);
    }
  }
  error.all = spread_of(std::move(all));
  error.away = spread_of(std::move(away));
  error.direction_rad = spread_of(std::move(direction));
  return error;
}

}  // namespace hapton
