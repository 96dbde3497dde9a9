#include "core/tool/separating_planes.h"

#include "core/math/rounded_to_float.h"
#include "core/tool/box_lanes.h"

namespace hapton {
namespace {

// How far a box reaches from its centre along a normal, which is given in the frame of the box's coordinates.
double reach_along(const ObbTree::Node& box, const Vec3& normal) {
  const Lanes4 axes[3] = {lanes_at(box.axes[0].data()), lanes_at(box.axes[1].data()), lanes_at(box.axes[2].data())};
  const Lanes4 reach = absolute(along(axes, normal)) * lanes_of(box.half_size());
  return reach[0] + reach[1] + reach[2];
}

}  // namespace

SeparatingPlanes::SeparatingPlanes(std::size_t most, double radius) : radius_(radius), groups_((most + kTogether - 1) / kTogether) {
  for (std::size_t i = 0; i < kTogether * groups_.size(); ++i) clear(i);
}

void SeparatingPlanes::restart(const Placement& reference) noexcept {
  reference_ = reference;
  reference_turn_ = reference.orientation.toRotationMatrix();
  turned_ = 0.0;
}

void SeparatingPlanes::FloatMap::set(const Map& map) {
  for (int k = 0; k < 3; ++k) {
    shift[k] = static_cast<float>(map.shift[k]);
    for (int i = 0; i < 3; ++i) turn[k][i] = static_cast<float>(map.turn(k, i));
  }
}

// Rounding errors of find_gaps. With M = Map::size, the sum of the magnitudes of all products and terms (the centre of a box is within
// sqrt(3) radii of the grip point), along_normals differs from its exact value by 2^-21 M at most: each product passes up to seven
// roundings of 2^-24, and the map was rounded. The steps after that round up to five times, each time by at most 2^-24 of the result, of M,
// and of radius times turned. The factors here are twice these errors or more.
void SeparatingPlanes::begin(const LinearizedMotion& motion, double turned) noexcept {
  at_ = motion.from;
  turn_ = motion.orientation;
  turned_ += turned;
  moved_ = {at_.position - reference_.position, turn_ - reference_turn_};
  const Map path{motion.shift, motion.turn_change * turn_};
  moved_float_.set(moved_);
  motion_float_.set(path);
  constexpr double kRounding = 0x1p-19;
  const double coordinates = 0x1p-45 * (1.0 + radius_ + at_.position.cwiseAbs().sum() + reference_.position.cwiseAbs().sum());
  const double start_error = kRounding * moved_.size(radius_) + coordinates;
  turned_float_ = float_at_least(turned_ * (1.0 + kRounding));
  angle_float_ = float_at_least((motion.angle + motion.sagitta) * (1.0 + kRounding));
  start_error_ = float_at_least(start_error);
  // Also includes the error of the centre's path.
  over_error_ = float_at_least(start_error + kRounding * path.size(radius_) + 2.0 * radius_ * motion.sagitta);
}

// The result is no longer than 1 after rounding, so that a gap along it is no larger than the distance.
Vec3 SeparatingPlanes::normal_along(const Vec3& direction) noexcept {
  const Vec3 unit = direction * ((1.0 - 0x1p-22) / direction.norm());
  return {rounded_to_float(unit.x()), rounded_to_float(unit.y()), rounded_to_float(unit.z())};
}

double SeparatingPlanes::gap_along(const Vec3& normal, const ObbTree::Node& tool, const ObbTree::Node& scene) const noexcept {
  const Vec3 between = at_.position + turn_ * tool.at() - scene.at();
  const double gap = normal.dot(between) - reach_along(tool, turn_.transpose() * normal) - reach_along(scene, normal);
  return gap - 0x1p-45 * between.cwiseAbs().sum();
}

void SeparatingPlanes::put(std::size_t i, const Vec3& normal, double gap, const ObbTree::Node& tool) noexcept {
  const Vec3 arm = tool.at();
  const double radius = tool.half_size().norm() * (1.0 + 0x1p-18);  // the axes are orthonormal within 2^-20
  const double rounding = 0x1p-45 * (1.0 + arm.cwiseAbs().sum() + at_.position.cwiseAbs().sum());
  Group& group = groups_[i / kTogether];
  const std::size_t lane = i % kTogether;
  for (int k = 0; k < 3; ++k) {
    group.normal[k][lane] = static_cast<float>(normal[k]);
    group.arm[k][lane] = tool.centre[k];
  }
  group.radius[lane] = float_at_least(radius);
  group.gap[lane] = float_at_most(gap - rounding - normal.dot(moved_.shift + moved_.turn * arm) + group.radius[lane] * turned_);
}

}  // namespace hapton
