#include "core/force/offset_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/force/contact_frame.h"
#include "core/force/friction_drag.h"

namespace hapton {
namespace {

constexpr double kMostError = 0x1p-42;  // of one step of the integration
constexpr double kConverged = 0x1p-50;

}  // namespace

OffsetDrag::OffsetDrag(std::span<const OffsetContact> contacts, std::span<const FrictionCoefficients> friction, double offset) noexcept
    : contacts_(contacts), friction_(friction), offset_(offset) {}

// As ContactMaterial: equal coefficients stay what they are.
FrictionCoefficients OffsetDrag::mean(const Pull& pull) const noexcept {
  FrictionCoefficients result = friction_[0];
  double sum = 0.0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    if (!(pull.multiplier[i] > 0.0)) continue;
    sum += pull.multiplier[i];
    const double share = pull.multiplier[i] / sum;
    result.at_rest += share * (friction_[i].at_rest - result.at_rest);
    result.sliding += share * (friction_[i].sliding - result.sliding);
  }
  return result;
}

bool OffsetDrag::find_pull(const Vec3& c, const Vec3& device, Pull& pull) const noexcept {
  const Vec3 whole = device - c;
  if (contacts_.size() == 1) {
    const Vec3 normal = contacts_[0].stand(c).normal;
    const double height = normal.dot(whole);
    pull.way = whole - height * normal;
    pull.way -= normal.dot(pull.way) * normal;  // what rounding left
    pull.length = pull.way.norm();
    pull.depth = -height;
    pull.normal = normal;
    pull.multiplier[0] = -height;
    pull.friction = friction_[0];
    return true;
  }
  ContactFrame frame;
  frame.count = static_cast<int>(contacts_.size());
  for (std::size_t i = 0; i < contacts_.size(); ++i) frame.normal[i] = contacts_[i].stand(c).normal;
  if (!frame.prepare()) return false;
  Vec3 push = Vec3::Zero();
  for (std::size_t i = 0; i < contacts_.size(); ++i) {
    pull.multiplier[i] = -frame.dual[i].dot(whole);
    push += pull.multiplier[i] * frame.normal[i];
  }
  pull.along = frame.along;
  pull.way = contacts_.size() == 2 ? Vec3(frame.along.dot(whole) * frame.along) : Vec3(Vec3::Zero());
  pull.length = pull.way.norm();
  pull.depth = push.norm();
  pull.normal = pull.depth > 0.0 ? Vec3(push / pull.depth) : frame.normal[0];
  pull.friction = mean(pull);
  return true;
}

Vec3 OffsetDrag::direction_of(const Pull& pull, const Vec3& motion) const noexcept {
  if (pull.length > kLeastLag) return pull.way / pull.length;
  if (contacts_.size() == 2) return pull.along.dot(motion) < 0.0 ? Vec3(-pull.along) : pull.along;
  const Vec3 way = motion - pull.normal.dot(motion) * pull.normal;
  const double length = way.norm();
  return length > 0.0 ? Vec3(way / length) : Vec3::Zero();
}

double OffsetDrag::find_drive(const Pull& pull, const Vec3& motion) const noexcept {
  return (direction_of(pull, motion) + pull.friction.sliding * pull.normal).dot(motion);
}

// The sum of multipliers times curvatures along the way.
double OffsetDrag::find_curving(const Pull& pull, const Vec3& way) const noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < contacts_.size(); ++i) sum += std::max(0.0, pull.multiplier[i]) * contacts_[i].curvature(way, offset_);
  return sum;
}

double OffsetDrag::find_stability(const Pull& pull) const noexcept {
  if (is_flat() || !(pull.length > 0.0)) return 1.0;
  const double mu = pull.friction.sliding;
  return 1.0 - (1.0 + mu * mu) * find_curving(pull, pull.way / pull.length);
}

Vec3 OffsetDrag::find_rate(const Pull& pull, const Vec3& motion) const noexcept {
  const Vec3 way = direction_of(pull, motion);
  const double mu = pull.friction.sliding;
  const double stability = is_flat() ? 1.0 : 1.0 - (1.0 + mu * mu) * find_curving(pull, way);
  return way * ((way + mu * pull.normal).dot(motion) / std::max(stability, 0x1p-30));
}

bool OffsetDrag::has_rate(const Vec3& c, const Vec3& device, const Vec3& motion, Vec3& rate) const noexcept {
  Pull pull;
  if (!find_pull(c, device, pull)) return false;
  const Vec3 way = direction_of(pull, motion);
  const double mu = pull.friction.sliding;
  const double stability = 1.0 - (1.0 + mu * mu) * find_curving(pull, way);
  if (!(stability > kLeastStability)) return false;
  rate = way * ((way + mu * pull.normal).dot(motion) / stability);
  return true;
}

bool OffsetDrag::restore(Vec3& c) const noexcept {
  constexpr int kMostRounds = 8;
  for (int round = 0; round < kMostRounds; ++round) {
    ContactFrame frame;
    std::array<double, 2> short_by{};
    double most = 0.0;
    frame.count = static_cast<int>(contacts_.size());
    for (std::size_t i = 0; i < contacts_.size(); ++i) {
      const OffsetContact::Stand stand = contacts_[i].stand(c);
      frame.normal[i] = stand.normal;
      short_by[i] = offset_ - stand.distance;
      most = std::max(most, std::fabs(short_by[i]));
    }
    if (most <= 0x1p-51) return true;
    if (most > offset_ || !frame.prepare()) return false;
    for (std::size_t i = 0; i < contacts_.size(); ++i) c += short_by[i] * frame.dual[i];
    if (most <= 0x1p-26 * offset_ && contacts_.size() == 1) return true;
  }
  return true;
}

// On one part: along w to where |w| = mu d.
void OffsetDrag::return_to_cone(const Vec3& device, Vec3& c) const noexcept {
  restore(c);
  Pull pull;
  if (!find_pull(c, device, pull) || !(pull.length > kLeastLag) || !(pull.depth > 0.0)) return;
  const double stability = find_stability(pull);
  if (!(stability > kLeastStability)) return;
  const double ahead = pull.excess() / stability;
  if (std::fabs(ahead) <= kConverged || std::fabs(ahead) > 0.5 * pull.length) return;
  c += ahead * (pull.way / pull.length);
  restore(c);
}

// From time 0 to 1. Pre: rate(time, place, rate) gives the velocity, or false where there is none.
template <class Rate, class Mend>
bool OffsetDrag::integrate(Vec3& c, int& tests, Rate&& rate, Mend&& mend) const noexcept {
  constexpr int kMostSteps = 128;
  double time = 0.0;
  double step = 1.0;
  Vec3 k1;
  if (!rate(time, c, k1)) return false;
  for (int i = 0; i < kMostSteps; ++i) {
    ++tests;
    const double h = std::min(step, 1.0 - time);
    Vec3 k2, k3, k4, k5, k6, k7;
    bool is_sound =
        rate(time + h / 5.0, c + h / 5.0 * k1, k2) && rate(time + 0.3 * h, c + h * (3.0 / 40.0 * k1 + 9.0 / 40.0 * k2), k3) &&
        rate(time + 0.8 * h, c + h * (44.0 / 45.0 * k1 - 56.0 / 15.0 * k2 + 32.0 / 9.0 * k3), k4) &&
        rate(time + 8.0 / 9.0 * h, c + h * (19372.0 / 6561.0 * k1 - 25360.0 / 2187.0 * k2 + 64448.0 / 6561.0 * k3 - 212.0 / 729.0 * k4),
             k5) &&
        rate(time + h,
             c + h * (9017.0 / 3168.0 * k1 - 355.0 / 33.0 * k2 + 46732.0 / 5247.0 * k3 + 49.0 / 176.0 * k4 - 5103.0 / 18656.0 * k5), k6);
    double error = std::numeric_limits<double>::infinity();
    Vec3 end;
    if (is_sound) {
      end = c + h * (35.0 / 384.0 * k1 + 500.0 / 1113.0 * k3 + 125.0 / 192.0 * k4 - 2187.0 / 6784.0 * k5 + 11.0 / 84.0 * k6);
      is_sound = rate(time + h, end, k7);
      error = h * (71.0 / 57600.0 * k1 - 71.0 / 16695.0 * k3 + 71.0 / 1920.0 * k4 - 17253.0 / 339200.0 * k5 + 22.0 / 525.0 * k6 -
                   1.0 / 40.0 * k7)
                      .norm();
    }
    if (!is_sound || !(error <= kMostError)) {
      step = h * (is_sound ? std::clamp(0.9 * std::pow(kMostError / error, 0.2), 0.1, 0.9) : 0.25);
      if (!(step > 0x1p-40)) return false;
      continue;
    }
    c = end;
    time = h < 1.0 - time ? time + h : 1.0;
    mend(time, c);
    if (time >= 1.0) return true;
    step = h * std::clamp(0.9 * std::pow(kMostError / std::max(error, 0x1p-70), 0.2), 0.5, 5.0);
    if (!rate(time, c, k1)) return false;
  }
  return false;
}

bool OffsetDrag::follow_on_face(const Vec3& from, const Vec3& to, Vec3& c) const noexcept {
  const OffsetContact& contact = contacts_[0];
  const Vec3& normal = contact.normal;
  const double start = std::max(0.0, offset_ - contact.stand(from).distance);
  const double end = std::max(0.0, offset_ - contact.stand(to).distance);
  const auto in_plane = [&](const Vec3& v) { return Vec3(v - normal.dot(v) * normal); };
  const Vec3 motion = in_plane(to - from);
  const Vec3 lag = in_plane(from - c);
  const double mu = friction_[0].sliding;
  const bool has_lag = mu * start > 0.0 && lag.norm() > kLeastLag;
  const SlidingLag sliding(has_lag ? lag : motion, motion, has_lag ? mu * start : std::numeric_limits<double>::min(), mu * (end - start));
  const Vec3 behind = mu * end > 0.0 ? sliding.at(1.0) : Vec3(Vec3::Zero());
  c = to + (offset_ - contact.stand(to).distance) * normal - behind;
  c += (offset_ - contact.stand(c).distance) * normal;
  return true;
}

bool OffsetDrag::follow_on_curve(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept {
  constexpr int kMostRounds = 24;
  constexpr double kMostTurn = 0.25;  // rad, of one step
  Pull before;
  if (!find_pull(c, from, before)) return false;
  Vec3 way = direction_of(before, to - from);
  if (way.isZero(0.0)) return false;
  for (int round = 0; round < kMostRounds; ++round) {
    ++tests;
    ContactFrame frame;
    std::array<double, 2> short_by{};
    frame.count = 2;
    for (std::size_t i = 0; i < 2; ++i) {
      const OffsetContact::Stand stand = contacts_[i].stand(c);
      frame.normal[i] = stand.normal;
      short_by[i] = offset_ - stand.distance;
    }
    Pull pull;
    if (!frame.prepare() || !find_pull(c, to, pull)) return false;
    way = frame.along.dot(way) < 0.0 ? Vec3(-frame.along) : frame.along;
    const double mu = pull.friction.sliding;
    const double stability = is_flat() ? 1.0 : 1.0 - (1.0 + mu * mu) * find_curving(pull, way);
    if (!(stability > kLeastStability)) return false;
    const double ahead = (way.dot(to - c) - mu * pull.depth) / stability;
    if (!is_flat() && std::fabs(ahead) > 2.0 * kMostTurn * offset_) return false;
    c += ahead * way + short_by[0] * frame.dual[0] + short_by[1] * frame.dual[1];
    const double step = std::max({std::fabs(ahead), std::fabs(short_by[0]), std::fabs(short_by[1])});
    if (step <= kConverged) return true;
  }
  return restore(c);
}

bool OffsetDrag::follow(const Vec3& from, const Vec3& to, Vec3& c, int& tests) const noexcept {
  if (contacts_.size() == 2) return follow_on_curve(from, to, c, tests);
  if (!contacts_[0].is_curved()) return follow_on_face(from, to, c);
  const Vec3 motion = to - from;
  const auto device = [&](double time) { return time < 1.0 ? Vec3(from + time * motion) : to; };
  return integrate(
      c, tests, [&](double time, const Vec3& place, Vec3& rate) { return has_rate(place, device(time), motion, rate); },
      [&](double time, Vec3& place) { return_to_cone(device(time), place); });
}

bool OffsetDrag::descend(const Vec3& device, const Vec3& way, double length, Vec3& c, int& tests) const noexcept {
  if (contacts_.size() == 2 || is_flat()) {
    c += length * way;
    return restore(c);
  }
  return integrate(
      c, tests,
      [&](double, const Vec3& place, Vec3& rate) {
        Pull pull;
        if (!find_pull(place, device, pull) || !(pull.length > 0.0)) return false;
        rate = (length / pull.length) * pull.way;
        return true;
      },
      [&](double, Vec3& place) { restore(place); });
}

double OffsetDrag::time_of_release(const Vec3& from, const Vec3& to) const noexcept {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const OffsetContact& contact = contacts_[0];
  const double before = contact.stand(from).distance - offset_;
  const double after = contact.stand(to).distance - offset_;
  if (!(after > 0.0)) return kNever;
  if (!contact.is_curved()) return before >= 0.0 ? 0.0 : before / (before - after);
  const Vec3 axis = contact.part == OffsetContact::Part::edge ? contact.axis() : Vec3(Vec3::Zero());
  const auto across = [&](const Vec3& v) { return Vec3(v - axis.dot(v) * axis); };
  const Vec3 off = across(from - contact.origin());
  const Vec3 motion = across(to - from);
  const double a = motion.squaredNorm();
  const double b = off.dot(motion);
  const double c = std::max(0.0, (offset_ - off.norm()) * (offset_ + off.norm()));
  if (!(a > 0.0)) return kNever;
  const double root = std::sqrt(b * b + a * c);
  return std::clamp(b > 0.0 ? c / (b + root) : (root - b) / a, 0.0, 1.0);
}

}  // namespace hapton
