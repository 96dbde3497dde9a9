#include "core/force/centre_path.h"

#include <algorithm>
#include <cmath>

namespace hapton {

CentrePath CentrePath::straight(const Vec3& from, const Vec3& to) noexcept {
  CentrePath path;
  path.start_ = from;
  path.end_ = to;
  path.rate_ = {to - from, Vec3::Zero(), Vec3::Zero()};
  return path;
}

CentrePath CentrePath::curved(const Vec3& from, const Vec3& to, const Vec3& slope_from, const Vec3& slope_to) noexcept {
  CentrePath path;
  path.start_ = from;
  path.end_ = to;
  const Vec3 chord = to - from;
  path.rate_ = {slope_from, 3.0 * chord - 2.0 * slope_from - slope_to, slope_from + slope_to - 2.0 * chord};
  path.bend_ = std::max((2.0 * path.rate_[1]).norm(), (2.0 * path.rate_[1] + 6.0 * path.rate_[2]).norm());
  return path;
}

Vec3 CentrePath::at(double time) const noexcept {
  if (time >= 1.0) return end_;
  return start_ + time * (rate_[0] + time * (rate_[1] + time * rate_[2]));
}

Vec3 CentrePath::slope(double time) const noexcept { return rate_[0] + time * (2.0 * rate_[1] + 3.0 * time * rate_[2]); }

double CentrePath::time_to_pass(const Vec3& origin, const Vec3& direction, double margin, double until) const noexcept {
  const auto beyond = [&](double time) { return direction.dot(at(time) - origin) - margin; };
  double high = until;
  double at_high = beyond(high);
  if (!(at_high > 0.0)) return kNever;
  double low = 0.0;
  double at_low = beyond(low);
  if (at_low >= 0.0) return at_high > at_low ? 0.0 : kNever;
  // False position, with the end that stays halved (Illinois).
  constexpr int kMostRounds = 40;
  for (int i = 0; i < kMostRounds; ++i) {
    const double time = low + (high - low) * (at_low / (at_low - at_high));
    if (is_straight() || !(high - low > 0x1p-50)) return std::min(time, until);
    const double here = beyond(time);
    if (std::fabs(here) <= 0x1p-52 || time <= low || time >= high) return time;
    if (here > 0.0) {
      high = time;
      at_high = here;
      at_low *= 0.5;
    } else {
      low = time;
      at_low = here;
      at_high *= 0.5;
    }
  }
  return high;
}

// When the distance falls to `level`, to a tolerance.
double CentrePath::time_below(const ContactTriangle& triangle, double level, double tolerance, double until, int& tests) const noexcept {
  constexpr int kMostRounds = 64;
  double time = 0.0;
  for (int i = 0; i < kMostRounds; ++i) {
    ++tests;
    const Separation now = triangle.separation(at(time));
    const Vec3 way = slope(time);
    const double approach = now.normal.dot(way) - normal_error(now) * way.norm();
    const double gap = now.distance - level;
    if (gap <= tolerance && (approach < 0.0 || gap < 0.0)) return time;
    // gap + approach x - bend / 2 x^2 = 0
    double step = 0.0;
    if (bend_ > 0.0) {
      const double root = std::sqrt(approach * approach + 2.0 * bend_ * std::max(gap, 0.0));
      step = approach < 0.0 ? 2.0 * std::max(gap, 0.0) / (root - approach) : (approach + root) / bend_;
    } else {
      if (!(approach < 0.0)) return kNever;
      step = gap / -approach;
    }
    time += std::max(step, 0x1p-50);
    if (!(time < until)) return kNever;
  }
  return time;
}

double CentrePath::time_to_block(const ContactTriangle& triangle, const Keep& keep, double until, int& tests) const noexcept {
  ++tests;
  const Separation start = triangle.separation(start_);
  const Vec3 way = rate_[0];
  const double approach = start.normal.dot(way) - normal_error(start) * way.norm();
  const double gap = start.distance - keep.offset;
  const double low = keep.offset - 0.5 * keep.slop;
  // Safe from the start: the parabola stays above.
  const double bottom = approach >= 0.0 ? gap + std::min(0.0, approach * until - 0.5 * bend_ * until * until)
                                        : gap + approach * until - 0.5 * bend_ * until * until;
  if (keep.offset + bottom > low) return kNever;
  // What rounding took from a centre that is as near as can be does not hold it.
  if (start.distance < low + keep.tolerance) {
    if (approach < 0.0) return 0.0;
    return time_below(triangle, start.distance - 0.125 * keep.slop, keep.tolerance, until, tests);
  }
  const double below = time_below(triangle, low, keep.tolerance, until, tests);
  if (below > until) return kNever;
  const double level = gap > keep.tolerance ? keep.offset : std::min(keep.offset - 0.25 * keep.slop, start.distance - keep.tolerance);
  return std::min(below, time_below(triangle, level, keep.tolerance, until, tests));
}

}  // namespace hapton
