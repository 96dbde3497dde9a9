#pragma once

#include <array>
#include <cstdint>

#include "core/math/types.h"

namespace hapton {

// The arm of a WoodenHaptics device. The numbers given are those of the "2016 edition"; other builds give theirs in a TOML file.
// A motor turns each body through a capstan and a cable: a the column, b the upper arm, c the lower arm.
struct WoodenArm {
  struct Body {
    double capstan_diameter_m = 0.010;
    double body_diameter_m = 0.120;
    double length_m = 0.0;
    double counts_per_turn = 2000.0;           // counts in one turn of the motor, all four edges counted
    double torque_constant_nm_per_a = 0.0259;  // the motor's
    double direction = 1.0;                    // -1: the encoder counts down as the angle grows
    double rest_rad = 0.0;                     // the angle in the rest pose, where the encoder says zero
    double mass_kg = 0.0;
    double mass_centre_m = 0.0;  // distance along the body from the joint about which it turns
  };
  std::array<Body, 3> bodies = {
      Body{.body_diameter_m = 0.160, .length_m = 0.080},
      Body{.body_diameter_m = 0.120, .length_m = 0.205, .mass_kg = 0.17, .mass_centre_m = 0.051},
      Body{.body_diameter_m = 0.120, .length_m = 0.245, .mass_kg = 0.11, .mass_centre_m = 0.091},
  };
  Vec3 origin_m = Vec3(0.22, 0.0, 0.08);  // origin of B: the workspace's centre, from the foot of the column, along the axes of B
};

// Frame: B, the base: z up along the column's axis, x forward where all angles are zero, y by the right-hand rule; its origin is
// WoodenArm::origin_m. Units: m, rad, N, N m, A. RT: yes, all of it pure.
//
// With angles a, b, c and the lengths La, Lb, Lc:
//   x = cos a (Lb sin b + Lc sin c) - x0
//   y = sin a (Lb sin b + Lc sin c) - y0
//   z = La + Lb cos b - Lc cos c - z0
// so that at zero the upper arm stands upright and the lower arm hangs down along it. b and c are both measured from the vertical, because
// the cable drives c directly, not the elbow angle.
class WoodenKinematics {
 public:
  explicit WoodenKinematics(const WoodenArm& arm) noexcept : arm_(arm) {}

  Vec3 angles_rad(const std::array<std::int16_t, 3>& counts) const noexcept;
  Vec3 position_m(const Vec3& angles_rad) const noexcept;
  // The derivatives of position_m with respect to the angles: a row for each coordinate, a column for each angle.
  Mat3 jacobian(const Vec3& angles_rad) const noexcept;

  // Potential energy of the upper and lower arm under gravity; zero at the height of the foot of the column (z = -origin_m.z() in B).
  double potential_energy_j(const Vec3& angles_rad) const noexcept;
  // Joint torques that hold the arms against gravity: the gradient of potential_energy_j.
  Vec3 gravity_torque_nm(const Vec3& angles_rad) const noexcept;

  // The joints' torque for a force on the device point: J^T F.
  Vec3 joint_torque_nm(const Vec3& angles_rad, const Vec3& force_n) const noexcept;
  Vec3 motor_current_a(const Vec3& joint_torque_nm) const noexcept;

  // The frame of the gimbal's base, at the end of the lower arm, in B.
  Quat lower_arm(const Vec3& angles_rad) const noexcept;

 private:
  // Transmission ratio with sign: turns of the joint for one turn of the motor.
  double ratio(std::size_t body) const noexcept;

  WoodenArm arm_;
};

}  // namespace hapton
