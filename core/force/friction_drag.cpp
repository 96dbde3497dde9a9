#include "core/force/friction_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {
namespace {

constexpr double kOnCone = 1e-9;  // of the cone's radius: a sliding proxy's lag is on the cone but for rounding
constexpr int kMostPhases = 16;   // each is a stick and a slip; in a straight motion two are enough, but for rounding

// When a lag that the proxy does not follow leaves a cone; infinite: not at all. 0 = |lag + t motion|^2 - (radius + t growth)^2 = a t^2 + 2
// b t + c.
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

// When it has become shorter than a cone is wide; infinite: not at all.
double find_rest(const Vec3& lag, const Vec3& motion, double radius, double growth) {
  const double a = growth * growth - motion.squaredNorm();
  const double b = radius * growth - lag.dot(motion);
  const double c = radius * radius - lag.squaredNorm();
  if (c >= 0.0) return 0.0;
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0.0)) return std::numeric_limits<double>::infinity();
  const double root = std::sqrt(discriminant);
  if (b > 0.0) return -c / (b + root);
  return a > 0.0 ? (root - b) / a : std::numeric_limits<double>::infinity();
}

}  // namespace

SlidingLag::SlidingLag(const Vec3& lag, const Vec3& motion, double radius, double growth) noexcept
    : way_(motion.norm()), radius_(radius), growth_(growth) {
  if (!(way_ > 0.0)) {
    ahead_ = lag.normalized();
    return;
  }
  ahead_ = motion / way_;
  const double along = lag.dot(ahead_);
  const Vec3 beside = lag - along * ahead_;
  const double width = beside.norm();
  if (!(width > 0.0)) {
    if (along < 0.0) {  // it turns round for nothing
      ahead_ = -ahead_;
      way_ = -way_;
    }
    return;
  }
  sideways_ = beside / width;
  // From whichever of two forms does not cancel.
  const double size = std::hypot(along, width);
  tangent_ = along >= 0.0 ? width / (size + along) : (size - along) / width;
}

// With the angle psi between lag and motion and the cone's radius R, R psi' = -|motion| sin psi.
double SlidingLag::tangent_at(double time) const noexcept {
  const double relative = time * growth_ / radius_;
  if (!(relative > -1.0)) return 0.0;
  const double turns = time * way_ / radius_ * (std::fabs(relative) > 1e-12 ? std::log1p(relative) / relative : 1.0);
  return tangent_ * std::exp(-turns);
}

Vec3 SlidingLag::at(double time) const noexcept {
  const double end = std::max(0.0, radius_ + time * growth_);
  if (!(tangent_ > 0.0)) return end * ahead_;
  const double tangent = tangent_at(time);
  const double squared = tangent * tangent;
  return (end / (1.0 + squared)) * ((1.0 - squared) * ahead_ + 2.0 * tangent * sideways_);
}

double SlidingLag::speed_at(double time) const noexcept {
  const double tangent = tangent_ > 0.0 ? tangent_at(time) : 0.0;
  const double squared = tangent * tangent;
  return way_ * (1.0 - squared) / (1.0 + squared) - growth_;
}

double SlidingLag::time_across(const Vec3& normal) const noexcept {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double along = normal.dot(ahead_);
  const double beside = normal.dot(sideways_);
  if (!(way_ > 0.0) || along == 0.0) return kNever;
  // cos(psi) along + sin(psi) beside = 0 with psi in (0, pi), and the tangent of half of it.
  const double size = std::hypot(along, beside);
  const double sine = std::fabs(along);
  const double cosine = along > 0.0 ? -beside : beside;
  const double wanted = cosine >= 0.0 ? sine / (size + cosine) : (size - cosine) / sine;
  if (!(wanted < tangent_) || !(wanted > 0.0)) return kNever;
  const double turns = std::log(tangent_ / wanted);
  const double relative = growth_ * turns / way_;
  const double time = std::fabs(relative) > 1e-12 ? radius_ / growth_ * std::expm1(relative) : radius_ * turns / way_;
  return time >= 0.0 ? time : kNever;
}

FrictionDrag drag_by_friction(const FrictionMotion& input) noexcept {
  const double growth = input.pressure_end - input.pressure_start;
  FrictionDrag now{input.lag, input.sliding};
  double t = 0.0;
  for (int phase = 0; phase < kMostPhases; ++phase) {
    const double pressure = input.pressure_start + t * growth;
    const double radius = input.friction_dynamic * pressure;
    const double widening = input.friction_dynamic * growth;
    if (now.sliding) {
      const double length = now.lag.norm();
      if (!(radius > 0.0) || !(length > 0.0)) return {Vec3::Zero(), true};
      if (length > radius) now.lag *= radius / length;
      // It goes on only where the device outruns the cone. The angle to the motion falls on the way, so it does not stop again.
      const bool outruns = now.lag.dot(input.motion) >= now.lag.norm() * widening;
      if (outruns && !(now.lag.norm() < radius * (1.0 - kOnCone))) {
        now.lag = SlidingLag(now.lag, (1.0 - t) * input.motion, radius, (1.0 - t) * widening).at(1.0);
        return now;
      }
    }
    const double held = now.sliding ? input.friction_dynamic : input.friction_static;
    const double slip = find_slip(now.lag, input.motion, held * pressure, held * growth);
    const double rest =
        now.sliding ? find_rest(now.lag, input.motion, FrictionMotion::kRest * radius, FrictionMotion::kRest * widening) : slip;
    const double next = std::min(slip, rest);
    if (!(next < 1.0 - t)) {
      now.lag += (1.0 - t) * input.motion;
      return now;
    }
    t += next;
    now.lag += next * input.motion;
    now.sliding = slip <= rest;
  }
  now.lag += (1.0 - t) * input.motion;
  return now;
}

}  // namespace hapton
