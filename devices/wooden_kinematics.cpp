#include "devices/wooden_kinematics.h"

#include <cmath>
#include <numbers>

namespace hapton {
namespace {

constexpr double kGravityMPerS2 = 9.80665;

}  // namespace

double WoodenKinematics::ratio(std::size_t body) const noexcept {
  const WoodenArm::Body& of = arm_.bodies[body];
  return of.direction * of.capstan_diameter_m / of.body_diameter_m;
}

Vec3 WoodenKinematics::angles_rad(const std::array<std::int16_t, 3>& counts) const noexcept {
  Vec3 angles;
  for (std::size_t n = 0; n < 3; ++n)
    angles[n] = arm_.bodies[n].rest_rad + 2.0 * std::numbers::pi * counts[n] / arm_.bodies[n].counts_per_turn * ratio(n);
  return angles;
}

Vec3 WoodenKinematics::position_m(const Vec3& angles) const noexcept {
  const auto& [a, b, c] = arm_.bodies;
  const double reach = b.length_m * std::sin(angles[1]) + c.length_m * std::sin(angles[2]);
  const double height = a.length_m + b.length_m * std::cos(angles[1]) - c.length_m * std::cos(angles[2]);
  return Vec3(std::cos(angles[0]) * reach, std::sin(angles[0]) * reach, height) - arm_.origin_m;
}

Mat3 WoodenKinematics::jacobian(const Vec3& angles) const noexcept {
  const auto& [a, b, c] = arm_.bodies;
  const double cos_a = std::cos(angles[0]), sin_a = std::sin(angles[0]);
  const double reach = b.length_m * std::sin(angles[1]) + c.length_m * std::sin(angles[2]);
  const double reach_b = b.length_m * std::cos(angles[1]), reach_c = c.length_m * std::cos(angles[2]);
  Mat3 j;
  j << -sin_a * reach, cos_a * reach_b, cos_a * reach_c,  //
      cos_a * reach, sin_a * reach_b, sin_a * reach_c,    //
      0.0, -b.length_m * std::sin(angles[1]), c.length_m * std::sin(angles[2]);
  return j;
}

// The column turns without rising, so its mass does not count. The lower arm hangs from the end of the upper arm.
double WoodenKinematics::potential_energy_j(const Vec3& angles) const noexcept {
  const auto& [a, b, c] = arm_.bodies;
  const double height_b = a.length_m + b.mass_centre_m * std::cos(angles[1]);
  const double height_c = a.length_m + b.length_m * std::cos(angles[1]) - c.mass_centre_m * std::cos(angles[2]);
  return kGravityMPerS2 * (b.mass_kg * height_b + c.mass_kg * height_c);
}

Vec3 WoodenKinematics::gravity_torque_nm(const Vec3& angles) const noexcept {
  const auto& [a, b, c] = arm_.bodies;
  return kGravityMPerS2 * Vec3(0.0, -(b.mass_kg * b.mass_centre_m + c.mass_kg * b.length_m) * std::sin(angles[1]),
                               c.mass_kg * c.mass_centre_m * std::sin(angles[2]));
}

Vec3 WoodenKinematics::joint_torque_nm(const Vec3& angles, const Vec3& force_n) const noexcept {
  return jacobian(angles).transpose() * force_n;
}

Vec3 WoodenKinematics::motor_current_a(const Vec3& torque) const noexcept {
  Vec3 current;
  for (std::size_t n = 0; n < 3; ++n) current[n] = torque[n] * ratio(n) / arm_.bodies[n].torque_constant_nm_per_a;
  return current;
}

// Turned with the column, then tilted so that -z points along the lower arm.
Quat WoodenKinematics::lower_arm(const Vec3& angles) const noexcept {
  return Quat(Eigen::AngleAxisd(angles[0], Vec3::UnitZ()) * Eigen::AngleAxisd(-angles[2], Vec3::UnitY()));
}

}  // namespace hapton
