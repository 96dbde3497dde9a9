#include "core/force/sphere/offset_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/sliding_friction.h"
#include "core/force/sphere/contact_frame.h"

namespace hapton {
namespace {

constexpr double kMaxError = 0x1p-36;    // largest error of one step of the integration
constexpr double kConverged = 0x1p-50;   // local units: a shorter step of Newton's method is within rounding
constexpr double kRestored = 0x1p-51;    // distance from the offset surface that rounding may leave
constexpr int kFewRounds = 4;            // after these, each round of Newton's method at least halves the error, if there is a solution
constexpr double kFirstPiece = 0x1p-18;  // share of the offset

}  // namespace

// Weighted as in ContactMaterial, so that the mean of equal coefficients is exactly that coefficient.
FrictionCoefficients OffsetDrag::mean(const Pull& pull) const noexcept {
  FrictionCoefficients result = friction_[0];
  double sum = 0.0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!(pull.multiplier[i] > 0.0)) continue;
    sum += pull.multiplier[i];
    const double share = pull.multiplier[i] / sum;
    result.static_mu += share * (friction_[i].static_mu - result.static_mu);
    result.dynamic_mu += share * (friction_[i].dynamic_mu - result.dynamic_mu);
  }
  return result;
}

bool OffsetDrag::find_pull(const Vec3& c, const Vec3& device, Pull& pull) const noexcept {
  const Vec3 total_pull = device - c;
  if (contacts_.size() == 1) {
    const Vec3 normal = contacts_[0].proximity(c).normal;
    const double height = normal.dot(total_pull);
    pull.tangential = total_pull - height * normal;
    pull.tangential -= normal.dot(pull.tangential) * normal;  // removes the rounding error of the line before
    pull.length = pull.tangential.norm();
    pull.depth = -height;
    pull.normal = normal;
    pull.multiplier[0] = -height;
    pull.friction = friction_[0];
    return true;
  }
  ContactFrame frame;
  frame.measure(contacts_, c, offset_);
  if (!frame.prepare()) return false;
  Vec3 reaction = Vec3::Zero();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    pull.multiplier[i] = -frame.dual[i].dot(total_pull);
    reaction += pull.multiplier[i] * frame.normal[i];
  }
  pull.along = frame.along;
  pull.tangential = contacts_.size() == 2 ? Vec3(frame.along.dot(total_pull) * frame.along) : Vec3(Vec3::Zero());
  pull.length = pull.tangential.norm();
  pull.depth = reaction.norm();
  pull.normal = pull.depth > 0.0 ? Vec3(reaction / pull.depth) : frame.normal[0];
  pull.friction = mean(pull);
  return true;
}

Vec3 OffsetDrag::direction_of(const Pull& pull, const Vec3& motion) const noexcept {
  if (pull.length > kMinPull) return pull.tangential / pull.length;
  if (contacts_.size() == 2) return pull.along.dot(motion) < 0.0 ? Vec3(-pull.along) : pull.along;
  const Vec3 direction = motion - pull.normal.dot(motion) * pull.normal;
  const double length = direction.norm();
  return length > 0.0 ? Vec3(direction / length) : Vec3::Zero();
}

double OffsetDrag::find_excess_rate(const Pull& pull, const Vec3& motion) const noexcept {
  return (direction_of(pull, motion) + pull.friction.dynamic_mu * pull.normal).dot(motion);
}

double OffsetDrag::find_stability(const Pull& pull, const Vec3& direction) const noexcept {
  if (is_flat()) return 1.0;
  double bent = 0.0;  // the sum of multipliers times curvatures
  for (std::size_t i = 0; i < contacts_.size(); ++i) bent += std::max(0.0, pull.multiplier[i]) * contacts_[i].curvature(direction, offset_);
  const double mu = pull.friction.dynamic_mu;
  return 1.0 - (1.0 + mu * mu) * bent;
}

double OffsetDrag::find_stability(const Pull& pull) const noexcept {
  return pull.length > 0.0 ? find_stability(pull, pull.tangential / pull.length) : 1.0;
}

Vec3 OffsetDrag::find_slope(const Pull& pull, const Vec3& motion) const noexcept {
  const Vec3 direction = direction_of(pull, motion);
  return direction * (direction + pull.friction.dynamic_mu * pull.normal).dot(motion);
}

Vec3 OffsetDrag::find_rate(const Pull& pull, const Vec3& motion) const noexcept {
  const Vec3 direction = direction_of(pull, motion);
  const double stability = std::max(find_stability(pull, direction), 0x1p-30);
  return direction * ((direction + pull.friction.dynamic_mu * pull.normal).dot(motion) / stability);
}

// Over a step, the distance from a part of the surface changes by its linear part and at most |step|^2 / (2 offset). True: what is left
// after the step needs no further round.
bool OffsetDrag::is_last_step(const Vec3& step) const noexcept { return step.squaredNorm() <= kRestored * offset_; }

bool OffsetDrag::restore(Vec3& c) const noexcept {
  int uncounted = 0;
  return restore(c, uncounted);
}

// Two parts that face each other across a slit may have no common point: then the search ends once it comes no nearer to both.
bool OffsetDrag::restore(Vec3& c, int& tests) const noexcept {
  constexpr int kMaxRounds = 8;  // a bound on the work; see kFewRounds
  double most_before = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMaxRounds; ++round) {
    ++tests;
    ContactFrame frame;
    frame.measure(contacts_, c, offset_);
    double most = 0.0;
    for (int i = 0; i < frame.count; ++i) most = std::max(most, std::fabs(frame.short_by[i]));
    if (most <= kRestored) return true;
    if (most > offset_ || !frame.prepare()) return false;
    Vec3 step = Vec3::Zero();
    for (int i = 0; i < frame.count; ++i) step += frame.short_by[i] * frame.dual[i];
    c += step;
    if (is_last_step(step) || (round >= kFewRounds && most > 0.5 * most_before)) return true;
    most_before = most;
  }
  return true;
}

// Integrates from 0 to `length` (Dormand & Prince 5(4)). `step`: in, the first step, 0: the whole length; out, a good next step. rate(at,
// rate) returns false where the rate is undefined. Returns the length that was integrated.
template <class Rate>
double OffsetDrag::integrate(Eigen::Vector4d& at, double length, double& step, int& tests, Rate&& rate) noexcept {
  using State = Eigen::Vector4d;
  constexpr int kWork = 7;  // units of work of one step
  double remaining = length;
  if (step == 0.0) step = std::fabs(length);
  State k1;
  if (!rate(at, k1)) return 0.0;
  for (int i = 0; i < kMaxSteps; ++i) {
    tests += kWork;
    const bool is_last = 1.0625 * step >= std::fabs(remaining);
    const double h = is_last ? remaining : std::copysign(step, length);
    State k2, k3, k4, k5, k6, k7;
    const auto stage = [&](const State& slope, State& k) { return rate(State(at + h * slope), k); };
    const bool has_stages =
        stage(0.2 * k1, k2) && stage(3.0 / 40.0 * k1 + 9.0 / 40.0 * k2, k3) &&
        stage(44.0 / 45.0 * k1 - 56.0 / 15.0 * k2 + 32.0 / 9.0 * k3, k4) &&
        stage(19372.0 / 6561.0 * k1 - 25360.0 / 2187.0 * k2 + 64448.0 / 6561.0 * k3 - 212.0 / 729.0 * k4, k5) &&
        stage(9017.0 / 3168.0 * k1 - 355.0 / 33.0 * k2 + 46732.0 / 5247.0 * k3 + 49.0 / 176.0 * k4 - 5103.0 / 18656.0 * k5, k6);
    State end;
    double error = std::numeric_limits<double>::infinity();
    if (has_stages) {
      end = at + h * (35.0 / 384.0 * k1 + 500.0 / 1113.0 * k3 + 125.0 / 192.0 * k4 - 2187.0 / 6784.0 * k5 + 11.0 / 84.0 * k6);
      if (rate(end, k7)) {
        error = std::fabs(h) * (71.0 / 57600.0 * k1 - 71.0 / 16695.0 * k3 + 71.0 / 1920.0 * k4 - 17253.0 / 339200.0 * k5 +
                                22.0 / 525.0 * k6 - 1.0 / 40.0 * k7)
                                   .norm();
      }
    }
    if (!(error <= kMaxError)) {
      step = std::fabs(h) * (std::isfinite(error) ? std::clamp(0.9 * std::pow(kMaxError / error, 0.2), 0.1, 0.9) : 0.25);
      if (!(step > 0x1p-30 * std::fabs(length))) break;
      continue;
    }
    at = end;
    const double next = std::fabs(h) * std::clamp(0.9 * std::pow(kMaxError / std::max(error, 0x1p-70), 0.2), 0.5, 5.0);
    step = is_last ? std::max(step, next) : next;
    if (is_last) return length;
    remaining -= h;
    k1 = k7;
  }
  return length - remaining;
}

// Removes the integration error: projects onto the surface, and onto the cone by a change of position or, where the cone hardly depends on
// the position, of time.
void OffsetDrag::return_to_flow(const Vec3& from, const Vec3& motion, Flow& at) const noexcept {
  constexpr double kMinDependence = 0.125;  // below this stability or rate, the cone hardly depends on position or time
  restore(at.centre);
  Pull pull;
  if (!find_pull(at.centre, from + at.time * motion, pull) || !(pull.length > kMinPull) || !(pull.depth > 0.0)) return;
  const double excess = pull.excess();
  if (std::fabs(excess) <= kConverged || std::fabs(excess) > 0.125 * pull.length) return;
  const double stability = find_stability(pull);
  const double excess_rate = find_excess_rate(pull, motion);
  if (std::fabs(stability) > kMinDependence) {
    at.centre += excess / stability * (pull.tangential / pull.length);
    restore(at.centre);
  } else if (excess_rate > kMinDependence * motion.norm()) {
    at.time -= excess / excess_rate;
  }
}

bool OffsetDrag::flow(const Vec3& from, const Vec3& to, double length, Flow& at, int& tests) const noexcept {
  const Vec3 motion = to - from;
  const double speed = motion.norm();
  if (!(speed > 0.0)) return false;
  if (contacts_.size() == 2) return flow_on_curve(from, motion, length, at, tests);
  // A pull that begins at zero has no direction there, and integrating from there would take many small steps. Over this first piece it
  // points along the motion of the device, up to second order.
  Pull start;
  at.followed = 0.0;
  if (!find_pull(at.centre, from + at.time * motion, start)) return false;
  const Vec3 slope = find_slope(start, motion);
  const double stability = find_stability(start);
  const double first = kFirstPiece * offset_ / std::max(slope.norm(), speed * 0x1p-20);
  if (start.length <= std::max(4.0 * kMinPull, kFirstPiece * kFirstPiece * offset_) && stability > 0.0 && first < length) {
    at.centre += first * slope;
    at.time += first * stability;
    return_to_flow(from, motion, at);
    length -= first;
    at.followed = first;
  }
  // The time scaled to a length, so that one tolerance fits all components.
  Eigen::Vector4d state(at.centre.x(), at.centre.y(), at.centre.z(), at.time * speed);
  const double followed = integrate(state, length, at.step, tests, [&](const Eigen::Vector4d& here, Eigen::Vector4d& rate) {
    Pull pull;
    const Vec3 c = here.head<3>();
    if (!find_pull(c, from + (here[3] / speed) * motion, pull)) return false;
    const Vec3 direction = direction_of(pull, motion);
    rate.head<3>() = direction * (direction + pull.friction.dynamic_mu * pull.normal).dot(motion);
    rate[3] = speed * find_stability(pull, direction);
    return true;
  });
  at.followed += followed;
  if (followed != length) return false;
  at.centre = state.head<3>();
  at.time = state[3] / speed;
  return_to_flow(from, motion, at);
  Pull pull;
  if (!find_pull(at.centre, from + at.time * motion, pull)) return false;
  at.slope = find_slope(pull, motion);
  return true;
}

// Moves c along the curve of two contacts, to the plane that is normal to `ahead` at the distance `length`. False: they do not meet.
bool OffsetDrag::move_along_curve(const Vec3& ahead, double length, Vec3& c, int& tests) const noexcept {
  constexpr int kMaxRounds = 16;  // a bound on the work; see kFewRounds
  const Vec3 start = c;
  c += length * ahead;
  double most_before = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMaxRounds; ++round) {
    ++tests;
    ContactFrame frame;
    frame.measure(contacts_, c, offset_);
    frame.count = 3;
    frame.normal[2] = ahead;
    frame.short_by[2] = length - ahead.dot(c - start);
    if (!frame.prepare()) return false;
    Vec3 step = Vec3::Zero();
    for (int i = 0; i < 3; ++i) step += frame.short_by[i] * frame.dual[i];
    c += step;
    const double most = std::max({std::fabs(frame.short_by[0]), std::fabs(frame.short_by[1]), std::fabs(frame.short_by[2])});
    if (most <= kRestored || is_last_step(step)) return true;
    if (round >= kFewRounds && most > 0.5 * most_before) break;  // there is no such place
    most_before = most;
  }
  return restore(c, tests);
}

// Moves `at` along the curve by `length`, and finds the time at which |w| = mu d there (symbols: offset_drag.h).
bool OffsetDrag::flow_on_curve(const Vec3& from, const Vec3& motion, double length, Flow& at, int& tests) const noexcept {
  constexpr int kMaxRounds = 16;  // rounds of Newton's method; a bound on the work
  Pull pull;
  if (!find_pull(at.centre, from + at.time * motion, pull)) return false;
  const Vec3 ahead = direction_of(pull, motion);
  const double excess_rate = find_excess_rate(pull, motion);
  Vec3 c = at.centre;
  double time = at.time + length * find_stability(pull);
  if (!move_along_curve(ahead, length * excess_rate, c, tests)) return false;
  const double speed = motion.norm();
  for (int round = 0; round < kMaxRounds; ++round) {
    ++tests;
    if (!find_pull(c, from + time * motion, pull) || !(pull.tangential.dot(ahead) > 0.0)) return false;
    const double rate = find_excess_rate(pull, motion);
    if (!(std::fabs(rate) > 0x1p-20 * speed)) return false;
    const double time_correction = -pull.excess() / rate;
    time += time_correction;
    if (!(std::fabs(time) <= 16.0)) return false;
    if (std::fabs(time_correction) * speed <= kConverged) break;
  }
  if (!find_pull(c, from + time * motion, pull)) return false;
  const Vec3 direction = direction_of(pull, motion);
  at.centre = c;
  at.time = time;
  at.slope = direction * (excess_rate / std::max(direction.dot(ahead), 0.25));
  return true;
}

bool OffsetDrag::follow_on_face(const Vec3& from, const Vec3& to, Vec3& c) const noexcept {
  const OffsetContact& contact = contacts_[0];
  const Vec3& normal = contact.normal;
  const double start = std::max(0.0, offset_ - contact.proximity(from).distance);
  const double end = std::max(0.0, offset_ - contact.proximity(to).distance);
  const auto in_plane = [&](const Vec3& v) { return Vec3(v - normal.dot(v) * normal); };
  const Vec3 motion = in_plane(to - from);
  const Vec3 pull = in_plane(from - c);
  const double mu = friction_[0].dynamic_mu;
  const bool has_pull = mu * start > 0.0 && pull.norm() > kMinPull;
  const SlidingPull sliding(has_pull ? pull : motion, motion, has_pull ? mu * start : std::numeric_limits<double>::min(),
                            mu * (end - start));
  const Vec3 pull_after = mu * end > 0.0 ? sliding.at(1.0) : Vec3(Vec3::Zero());
  c = to + (offset_ - contact.proximity(to).distance) * normal - pull_after;
  c += (offset_ - contact.proximity(c).distance) * normal;
  return true;
}

bool OffsetDrag::follow_on_curve(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept {
  constexpr int kMaxRounds = 24;     // rounds of Newton's method; a bound on the work
  constexpr double kMaxTurn = 0.25;  // rad, in one step
  Pull before;
  if (!find_pull(c, from, before)) return false;
  Vec3 direction = direction_of(before, to - from);
  if (direction.isZero(0.0)) return false;
  for (int round = 0; round < kMaxRounds; ++round) {
    tests += 2;
    ContactFrame frame;
    frame.measure(contacts_, c, offset_);
    Pull pull;
    if (!frame.prepare() || !find_pull(c, to, pull)) return false;
    direction = frame.along.dot(direction) < 0.0 ? Vec3(-frame.along) : frame.along;
    const double stability = find_stability(pull, direction);
    if (!(stability > kMinStability)) return false;
    const double ahead = (direction.dot(to - c) - pull.friction.dynamic_mu * pull.depth) / stability;
    if (!is_flat() && std::fabs(ahead) > 2.0 * kMaxTurn * offset_) return false;
    c += ahead * direction + frame.short_by[0] * frame.dual[0] + frame.short_by[1] * frame.dual[1];
    const double step = std::max({std::fabs(ahead), std::fabs(frame.short_by[0]), std::fabs(frame.short_by[1])});
    if (step <= kConverged) return true;
  }
  return restore(c);
}

bool OffsetDrag::follow(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept {
  return contacts_.size() == 2 ? follow_on_curve(from, to, c, tests) : follow_on_face(from, to, c);
}

// Around an edge or a vertex, dc = w ds. Let R be the offset, phi the angle about the axis from the centre to the device, rho the distance
// of the device from the axis, and z the distance along the axis by which the device is ahead of the centre (0 for a vertex). Then dphi =
// -rho / R sin phi ds and dz = -z ds, so with s = 0 at the start
//
//   tan(phi / 2) = tan(phi_0 / 2) exp(-rho / R s),   z = z_0 exp(-s).
//
// The parameter is R (phi_0 - phi) or z_0 - z, whichever changes faster at the start, scaled to be the length of the path there.
void OffsetDrag::descend_around(const Vec3& device, double length, Descent& at) const noexcept {
  constexpr double kMin = std::numeric_limits<double>::min();
  const OffsetContact& contact = contacts_[0];
  const Vec3 normal = contact.proximity(at.centre).normal;
  const bool is_edge = contact.part == Feature::edge;
  const Vec3& axis = contact.axis;
  const double rise = is_edge ? axis.dot(device - at.centre) : 0.0;
  const Vec3 off = device - contact.origin();
  const Vec3 across = off - axis.dot(off) * axis;
  const double ahead = normal.dot(across);
  Vec3 sideways = across - ahead * normal;
  sideways -= axis.dot(sideways) * axis;
  const double side = sideways.norm();
  const double rho = std::hypot(side, ahead);
  const double pull = std::hypot(side, rise);
  const Vec3 direction = side > 0.0 ? Vec3(sideways / side) : Vec3(Vec3::Zero());
  const double tangent = ahead > 0.0 ? side / (rho + ahead) : (rho - ahead) / std::max(side, kMin);
  const bool is_by_angle = side >= std::fabs(rise);
  const double faster_component = std::max(side, std::fabs(rise));
  const double part = length * faster_component / pull;
  double half_turn_tangent = 0.0;  // tan of half the angle from the start
  double rise_share = 0.0;         // exp(-s)
  if (is_by_angle) {
    half_turn_tangent = std::min(std::tan(std::min(0.5 * part / offset_, 1.5)), tangent);
    const double lost_share = half_turn_tangent * (1.0 / tangent + tangent) / (1.0 + tangent * half_turn_tangent);  // of `tangent`
    rise_share = lost_share < 1.0 ? std::exp(offset_ / rho * std::log1p(-lost_share)) : 0.0;
  } else {
    rise_share = std::max(0.0, 1.0 - part / std::fabs(rise));
    const double lost_share = rise_share > 0.0 ? -std::expm1(rho / offset_ * std::log(rise_share)) : rho > 0.0 ? 1.0 : 0.0;
    half_turn_tangent = tangent * lost_share / (1.0 + tangent * tangent * (1.0 - lost_share));
  }
  const double squared = half_turn_tangent * half_turn_tangent;
  const double sine = 2.0 * half_turn_tangent / (1.0 + squared);
  const double one_minus_cosine = 2.0 * squared / (1.0 + squared);
  const double climbed = is_by_angle ? rise * (1.0 - rise_share) : std::copysign(std::min(part, std::fabs(rise)), rise);
  at.centre += offset_ * (sine * direction - one_minus_cosine * normal) + climbed * axis;
  // w at the new position, in units of its faster component.
  const double side_there = side * (1.0 - one_minus_cosine) - ahead * sine;
  const double rise_there = rise * rise_share;
  const double scale = faster_component / pull / std::max(is_by_angle ? side_there : std::fabs(rise_there), kMin);
  at.slope = scale * (side_there * ((1.0 - one_minus_cosine) * direction - sine * normal) + rise_there * axis);
}

bool OffsetDrag::descend(const Vec3& device, const Vec3& along, double length, Descent& at, int& tests) const noexcept {
  ++tests;
  if (contacts_.size() == 2) {
    ContactFrame frame;
    if (!move_along_curve(along, length, at.centre, tests)) return false;
    frame.measure(contacts_, at.centre, offset_);
    if (!frame.prepare()) return false;
    const double ahead = frame.along.dot(along);
    at.slope = frame.along * ((ahead < 0.0 ? -1.0 : 1.0) / std::max(0.5, std::fabs(ahead)));
    return true;
  }
  if (is_flat()) {
    at.centre += length * along;
    at.slope = along;
  } else {
    descend_around(device, length, at);
  }
  return restore(at.centre) && at.slope.allFinite();
}

double OffsetDrag::time_of_release(const Vec3& from, const Vec3& to, const Pull& pull) const noexcept {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const OffsetContact& contact = contacts_[0];
  const double after = contact.proximity(to).distance - offset_;
  if (!(after > 0.0)) return kInfinity;
  if (!contact.is_curved()) return pull.depth > 0.0 ? pull.depth / (pull.depth + after) : 0.0;
  const Vec3& axis = contact.axis;
  const auto across = [&](const Vec3& v) { return Vec3(v - axis.dot(v) * axis); };
  const Vec3 off = across(from - contact.origin());
  const Vec3 motion = across(to - from);
  const double a = motion.squaredNorm();
  const double b = off.dot(motion);
  const double c = (offset_ - off.norm()) * (offset_ + off.norm());
  const double squared = b * b + a * c;
  if (!(a > 0.0) || !(squared >= 0.0)) return kInfinity;
  const double root = std::sqrt(squared);
  const double time = b > 0.0 ? c / (b + root) : (root - b) / a;
  // Beyond the axis of an edge the device is outside as well, but not on the side of the centre.
  if (!(time > 0.0)) return pull.depth <= kMinPull ? 0.0 : kInfinity;
  return time <= 1.0 && pull.normal.dot(off + time * motion) > 0.0 ? time : kInfinity;
}

}  // namespace hapton
