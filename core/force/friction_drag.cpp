#include "core/force/friction_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {
namespace {

constexpr double kOnCone = 1e-9;  // of the cone's radius: a sliding proxy's lag is on the cone but for rounding
constexpr int kMostPhases = 16;   // each is a stick and a slip; in a straight motion two are enough, but for rounding

// When a sticking proxy's lag leaves the cone; infinite: not at all. 0 = |lag + t motion|^2 - (radius + t growth)^2 = a t^2 + 2 b t + c.
double find_slip(const Vec3& lag, const Vec3& motion, double radius, double growth) {
  const double a = motion.squaredNorm() - growth * growth;
  const double b = lag.dot(motion) - radius * growth;
  const double c = std::min(0.0, lag.squaredNorm() - radius * radius);
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0.0)) return std::numeric_limits<double>::infinity();
  const double root = std::sqrt(discriminant);
  if (b > 0.0) return -c / (b + root);
  return a > 0.0 ? (root - b) / a : std::numeric_limits<double>::infinity();
}

// The lag after sliding for `share` of the motion, while the cone's radius grows from `radius` by `growth`.
Vec3 slide(const Vec3& lag, const Vec3& motion, double radius, double growth) {
  const double end = radius + growth;
  const double way = motion.norm();
  if (!(way > 0.0)) return lag * (end / radius);
  const Vec3 ahead = motion / way;
  const double along = lag.dot(ahead);
  const Vec3 beside = lag - along * ahead;
  const double width = beside.norm();
  const double relative = growth / radius;
  const double turns = way / radius * (std::fabs(relative) > 1e-12 ? std::log1p(relative) / relative : 1.0);
  // tan(psi / 2), from whichever of two forms does not cancel.
  const double size = std::hypot(along, width);
  const double half = along >= 0.0 ? width / (size + along) : (size - along) / width;
  const double angle = 2.0 * std::atan(half * std::exp(-turns));
  const Vec3 sideways = width > 0.0 ? Vec3(beside / width) : Vec3(Vec3::Zero());
  return end * (std::cos(angle) * ahead + std::sin(angle) * sideways);
}

}  // namespace

FrictionDrag drag_by_friction(const FrictionMotion& input) noexcept {
  const double growth = input.pressure_end - input.pressure_start;
  FrictionDrag now{input.lag, input.sliding};
  double t = 0.0;
  for (int phase = 0; phase < kMostPhases; ++phase) {
    const double pressure = input.pressure_start + t * growth;
    if (!now.sliding) {
      const double slip = find_slip(now.lag, input.motion, input.friction_static * pressure, input.friction_static * growth);
      if (!(slip < 1.0 - t)) {
        now.lag += (1.0 - t) * input.motion;
        return now;
      }
      t += slip;
      now.lag += slip * input.motion;
      now.sliding = true;
    }
    const double radius = input.friction_dynamic * (input.pressure_start + t * growth);
    const double length = now.lag.norm();
    if (!(radius > 0.0) || !(length > 0.0)) return {Vec3::Zero(), true};
    if (length > radius) now.lag *= radius / length;
    // It goes on sliding only where the device outruns the cone. The angle to the motion falls on the way, so it never stops again.
    const bool outruns = now.lag.dot(input.motion) >= now.lag.norm() * input.friction_dynamic * growth;
    if (outruns && !(now.lag.norm() < radius * (1.0 - kOnCone))) {
      now.lag = slide(now.lag, (1.0 - t) * input.motion, radius, (1.0 - t) * input.friction_dynamic * growth);
      return now;
    }
    now.sliding = false;
  }
  now.lag += (1.0 - t) * input.motion;
  return now;
}

}  // namespace hapton
