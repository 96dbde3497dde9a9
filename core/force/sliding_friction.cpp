#include "core/force/sliding_friction.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {
namespace {

constexpr double kOnCone = 1e-9;  // share of the cone's radius: a sliding proxy's pull equals the radius up to rounding
constexpr int kMaxPhases = 16;    // each is one stick and one slip; a straight motion needs two, the rest allows for rounding

constexpr double kNever = std::numeric_limits<double>::infinity();

// The first time at which a t^2 + 2 b t + c has risen to zero. Pre: c <= 0.
double time_of_zero_of(double a, double b, double c) {
  const double discriminant = b * b - a * c;
  if (!(discriminant >= 0.0)) return kNever;
  const double root = std::sqrt(discriminant);
  if (b > 0.0) return -c / (b + root);
  return a > 0.0 ? (root - b) / a : kNever;
}

// The time at which the pull on a sticking proxy leaves the cone; infinite: never. Root of |pull + t motion|^2 - (radius + t growth)^2.
double find_slip_time(const Vec3& pull, const Vec3& motion, double radius, double growth) {
  return time_of_zero_of(motion.squaredNorm() - growth * growth, pull.dot(motion) - radius * growth,
                         std::min(0.0, pull.squaredNorm() - radius * radius));
}

// The time at which the pull on a stopped proxy has become shorter than the cone's radius; infinite: never.
double find_restick_time(const Vec3& pull, const Vec3& motion, double radius, double growth) {
  const double c = radius * radius - pull.squaredNorm();
  if (c >= 0.0) return 0.0;
  return time_of_zero_of(growth * growth - motion.squaredNorm(), radius * growth - pull.dot(motion), c);
}

}  // namespace

SlidingPull::SlidingPull(const Vec3& pull, const Vec3& motion, double radius, double growth) noexcept
    : distance_(motion.norm()), radius_(radius), growth_(growth) {
  if (!(distance_ > 0.0)) {
    ahead_ = pull.normalized();
    return;
  }
  ahead_ = motion / distance_;
  const double along = pull.dot(ahead_);
  const Vec3 beside = pull - along * ahead_;
  const double width = beside.norm();
  if (!(width > 0.0)) {
    if (along < 0.0) {  // pull against the motion: both directions are reversed, so the angle is zero
      ahead_ = -ahead_;
      distance_ = -distance_;
    }
    return;
  }
  sideways_ = beside / width;
  // Two forms of the same value; the one without cancellation is used.
  const double size = std::hypot(along, width);
  tangent_ = along >= 0.0 ? width / (size + along) : (size - along) / width;
}

// With the angle psi between pull and motion and the cone's radius R, R psi' = -|motion| sin psi.
double SlidingPull::tangent_at(double time) const noexcept {
  const double relative = time * growth_ / radius_;
  if (!(relative > -1.0)) return 0.0;
  const double exponent = time * distance_ / radius_ * (std::fabs(relative) > 1e-12 ? std::log1p(relative) / relative : 1.0);
  return tangent_ * std::exp(-exponent);
}

Vec3 SlidingPull::at(double time) const noexcept {
  const double end = std::max(0.0, radius_ + time * growth_);
  if (!(tangent_ > 0.0)) return end * ahead_;
  const double tangent = tangent_at(time);
  const double squared = tangent * tangent;
  return (end / (1.0 + squared)) * ((1.0 - squared) * ahead_ + 2.0 * tangent * sideways_);
}

double SlidingPull::speed_at(double time) const noexcept {
  const double tangent = tangent_ > 0.0 ? tangent_at(time) : 0.0;
  const double squared = tangent * tangent;
  return distance_ * (1.0 - squared) / (1.0 + squared) - growth_;
}

double SlidingPull::time_across(const Vec3& normal) const noexcept {
  const double along = normal.dot(ahead_);
  const double beside = normal.dot(sideways_);
  if (!(distance_ > 0.0) || along == 0.0) return kNever;
  // Solves cos(psi) along + sin(psi) beside = 0 for psi in (0, pi), as the tangent of psi / 2.
  const double size = std::hypot(along, beside);
  const double sine = std::fabs(along);
  const double cosine = along > 0.0 ? -beside : beside;
  const double target_tangent = cosine >= 0.0 ? sine / (size + cosine) : (size - cosine) / sine;
  if (!(target_tangent < tangent_) || !(target_tangent > 0.0)) return kNever;
  const double exponent = std::log(tangent_ / target_tangent);
  const double relative = growth_ * exponent / distance_;
  const double time = std::fabs(relative) > 1e-12 ? radius_ / growth_ * std::expm1(relative) : radius_ * exponent / distance_;
  return time >= 0.0 ? time : kNever;
}

FrictionDrag drag_by_friction(const FrictionMotion& input) noexcept {
  const double growth = input.pressure_end - input.pressure_start;
  FrictionDrag state{input.pull, input.sliding};
  double t = 0.0;
  for (int phase = 0; phase < kMaxPhases; ++phase) {
    const double pressure = input.pressure_start + t * growth;
    const double radius = input.friction_dynamic * pressure;
    const double widening = input.friction_dynamic * growth;
    if (state.sliding) {
      const double length = state.pull.norm();
      if (!(radius > 0.0) || !(length > 0.0)) return {Vec3::Zero(), true};
      if (length > radius) state.pull *= radius / length;
      // The proxy slides on only if the device moves faster than the cone grows. The angle between pull and motion only decreases, so the
      // proxy then does not stop again.
      const bool outruns = state.pull.dot(input.motion) >= state.pull.norm() * widening;
      if (outruns && !(state.pull.norm() < radius * (1.0 - kOnCone))) {
        state.pull = SlidingPull(state.pull, (1.0 - t) * input.motion, radius, (1.0 - t) * widening).at(1.0);
        return state;
      }
    }
    const double coefficient = state.sliding ? input.friction_dynamic : input.friction_static;
    const double slip_time = find_slip_time(state.pull, input.motion, coefficient * pressure, coefficient * growth);
    const double restick_time =
        state.sliding ? find_restick_time(state.pull, input.motion, FrictionMotion::kRestick * radius, FrictionMotion::kRestick * widening)
                      : slip_time;
    const double time_to_next = std::min(slip_time, restick_time);
    if (!(time_to_next < 1.0 - t)) {
      state.pull += (1.0 - t) * input.motion;
      return state;
    }
    t += time_to_next;
    state.pull += time_to_next * input.motion;
    state.sliding = slip_time <= restick_time;
  }
  state.pull += (1.0 - t) * input.motion;
  return state;
}

}  // namespace hapton
