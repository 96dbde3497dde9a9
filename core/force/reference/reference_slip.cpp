// A sphere that slips over edges and vertices under friction, with the device held: the direction of its path turns on the way.
#include <algorithm>
#include <array>

#include "core/force/reference/reference_proxy.h"

namespace hapton {
namespace {

constexpr double kLongestSlip = 0x1p-5;  // rest offsets, in one piece: the error of a piece is of fifth order
constexpr double kMaxTurn = 0x1p-4;      // rad: turn of the direction in one piece
constexpr double kStraight = 0x1p-20;    // rest offsets: over so short a motion a part of the surface is flat to 2^-41 rest offsets
constexpr double kMinSine2 = 1e-10;      // squared sine of the angle between two parts: flatter ones have no curve in common
constexpr int kMaxRounds = 8;            // rounds of Newton's method

}  // namespace

// The direction of steepest descent at p over the parts in contact. `near` then holds their points closest to p.
Vec3 ReferenceProxy::SlipParts::direction_at(const Vec3& p, const Vec3& device) noexcept {
  std::array<HalfSpace, 2> half_spaces;
  for (std::size_t i = 0; i < count; ++i) {
    near[i] = closest_point(shape[i], p);
    half_spaces[i] = {near[i].direction, 0.0};
  }
  const HalfSpaceProjection motion = project_onto_half_spaces(device - p, std::span(half_spaces).first(count), kFeasible);
  if (!motion.feasible || static_cast<std::size_t>(motion.count) != count) return Vec3::Zero();
  const double length = motion.point.norm();
  return length > 0.0 ? Vec3(motion.point / length) : Vec3(Vec3::Zero());
}

// Moves p, by the shortest way, to where its distances from the parts are `near_distance`.
bool ReferenceProxy::SlipParts::restore(Vec3& p) const noexcept {
  for (int round = 0; round < kMaxRounds; ++round) {
    std::array<Vec3, 2> normal;
    std::array<double, 2> short_by{};
    for (std::size_t i = 0; i < count; ++i) {
      const ClosestPoint at = closest_point(shape[i], p);
      normal[i] = at.direction;
      short_by[i] = near_distance[i] - at.distance;
    }
    if (count == 1) {
      p += short_by[0] * normal[0];
    } else {
      const double cosine = normal[0].dot(normal[1]);
      const double sine2 = 1.0 - cosine * cosine;
      if (!(sine2 > kMinSine2)) return false;
      p += ((short_by[0] - cosine * short_by[1]) / sine2) * normal[0] + ((short_by[1] - cosine * short_by[0]) / sine2) * normal[1];
    }
    if (std::max(std::abs(short_by[0]), std::abs(short_by[1])) <= kStill) return true;
  }
  return false;
}

// Follows the direction of descent for the length of `motion` or a piece of it, by the classical Runge-Kutta method. False, and moves
// nothing, where the path is straight or the direction is not defined: the motion can be made as it is.
bool ReferenceProxy::slip(const Vec3& device, const Pull& pull, const Vec3& motion) noexcept {
  if (!has_friction() || !is_sphere() || pull.motion.count < 1 || pull.motion.count > 2) return false;
  const double length = motion.norm();
  SlipParts parts;
  parts.count = static_cast<std::size_t>(pull.motion.count);
  bool is_round = false;
  for (std::size_t i = 0; i < parts.count; ++i) {
    const Contact& contact = state_.contacts[pull.motion.active[i]];
    if (contact.near.distance < rest_offset_ - 2.0 * kTolerance) return false;  // an overlap is resolved first
    parts.shape[i] = contact.face.shape;
    parts.near_distance[i] = contact.near.distance;
    is_round |= contact.near.feature != TriangleFeature::face;
  }
  if (!is_round || !(length > kStraight * rest_offset_)) return false;
  const Vec3 start = state_.position;
  const Vec3 first = parts.direction_at(start, device);
  if (first.isZero(0.0)) return false;
  const std::array<ClosestPoint, 2> here = parts.near;
  const auto is_as_here = [&] {
    for (std::size_t i = 0; i < parts.count; ++i) {
      if (parts.near[i].feature != here[i].feature) return false;
    }
    return true;
  };
  for (double h = std::min(length, kLongestSlip * rest_offset_); h > kShortestSlip * rest_offset_; h *= 0.5) {
    const Vec3 second = parts.direction_at(start + 0.5 * h * first, device);
    bool is_one_piece = is_as_here();
    const Vec3 third = parts.direction_at(start + 0.5 * h * second, device);
    is_one_piece &= is_as_here();
    const Vec3 fourth = parts.direction_at(start + h * third, device);
    is_one_piece &= is_as_here() && (fourth - first).norm() <= kMaxTurn;
    Vec3 end = start + (h / 6.0) * (first + 2.0 * (second + third) + fourth);
    if (!is_one_piece || !parts.restore(end)) continue;
    const Vec3 corner = start + 0.5 * h * first;
    if (advance(corner - start) && advance(end - state_.position)) return true;
    if (h <= 2.0 * kShortestSlip * rest_offset_) return true;  // the proxy has moved to where it is stopped
    state_.position = start;
  }
  const double shortest = std::min(length, kShortestSlip * rest_offset_);
  advance((shortest / length) * motion);
  return true;
}

}  // namespace hapton
