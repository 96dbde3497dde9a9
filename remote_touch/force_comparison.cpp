#include "remote_touch/force_comparison.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "remote_touch/effective_offset.h"

namespace hapton {
namespace {

constexpr double kStepCostShare = 0.05;  // cost of a change of the lateness by 1 ms, as a share of the RMS of the zero-delay force

double angle_deg(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi; }

void compare_directions(const std::vector<ForceRow>& rows, ForceComparison& comparison) {
  double squares = 0.0;
  std::size_t compared = 0;
  for (const ForceRow& row : rows) {
    if (row.force_n.norm() <= kMinN || row.zero_delay_n.norm() <= kMinN) continue;
    const double angle = angle_deg(row.force_n, row.zero_delay_n);
    squares += angle * angle;
    ++compared;
    comparison.direction_max_deg = std::max(comparison.direction_max_deg, angle);
  }
  if (compared > 0) comparison.direction_rms_deg = std::sqrt(squares / static_cast<double>(compared));
}

void count_falls(const std::vector<ForceRow>& rows, double period_s, ForceComparison& comparison) {
  bool was_falling = false;
  for (const ForceRow& row : rows) {
    const bool is_falling = row.penetration_m > kFallM && !(row.force_n.dot(row.zero_delay_n) > 0.0);
    comparison.falls += is_falling && !was_falling ? 1 : 0;
    comparison.fall_s += is_falling ? period_s : 0.0;
    was_falling = is_falling;
  }
}

// The most energy that the force has given until any row. Each force is held until the next row.
template <class Force>
double most_given_j(const std::vector<ForceRow>& rows, Force force_of) {
  double given_j = 0.0;
  double most_j = 0.0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    given_j += force_of(rows[i - 1]).dot(rows[i].p_WD - rows[i - 1].p_WD);
    most_j = std::max(most_j, given_j);
  }
  return most_j;
}

}  // namespace

ForceComparison compare_forces(const std::vector<ForceRow>& rows, double period_s, double most_late_s) {
  ForceComparison comparison;
  double error_squares = 0.0;
  double reference_squares = 0.0;
  std::size_t contact_rows = 0;
  std::vector<Vec3> forces;
  std::vector<Vec3> zero_delay;
  for (const ForceRow& row : rows) {
    const double error_n = (row.force_n - row.zero_delay_n).norm();
    error_squares += error_n * error_n;
    reference_squares += row.zero_delay_n.squaredNorm();
    contact_rows += row.zero_delay_n.isZero(0.0) ? 0 : 1;
    comparison.error_max_n = std::max(comparison.error_max_n, error_n);
    forces.push_back(row.force_n);
    zero_delay.push_back(row.zero_delay_n);
  }
  if (contact_rows == 0) return comparison;
  comparison.error_rms = std::sqrt(error_squares / reference_squares);
  comparison.contact_s = period_s * static_cast<double>(contact_rows);
  const double rms_n = std::sqrt(reference_squares / static_cast<double>(contact_rows));
  const auto most_late = static_cast<std::size_t>(std::lround(most_late_s / period_s));
  const double step_cost = kStepCostShare * rms_n * period_s / 1e-3;
  const EffectiveOffset offset = find_effective_offset(forces, zero_delay, period_s, most_late, step_cost, kMinN);
  comparison.time_offset_s = offset.time_s;
  comparison.value_offset = offset.value / rms_n;
  compare_directions(rows, comparison);
  count_falls(rows, period_s, comparison);
  comparison.generated_j = most_given_j(rows, [](const ForceRow& row) { return row.force_n; });
  comparison.zero_delay_generated_j = most_given_j(rows, [](const ForceRow& row) { return row.zero_delay_n; });
  return comparison;
}

}  // namespace hapton
