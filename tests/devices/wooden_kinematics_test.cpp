#include "devices/wooden_kinematics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace hapton {
namespace {

// A build that differs from the default: its values are different and not round.
WoodenArm odd_arm() {
  WoodenArm arm;
  arm.bodies[0] = {.capstan_diameter_m = 0.011,
                   .body_diameter_m = 0.17,
                   .length_m = 0.07,
                   .counts_per_turn = 4096,
                   .torque_constant_nm_per_a = 0.03,
                   .direction = -1.0};
  arm.bodies[1] = {.capstan_diameter_m = 0.012,
                   .body_diameter_m = 0.13,
                   .length_m = 0.19,
                   .counts_per_turn = 2000,
                   .torque_constant_nm_per_a = 0.026,
                   .direction = 1.0,
                   .rest_rad = 0.1,
                   .mass_kg = 0.2,
                   .mass_centre_m = 0.06};
  arm.bodies[2] = {.capstan_diameter_m = 0.009,
                   .body_diameter_m = 0.11,
                   .length_m = 0.26,
                   .counts_per_turn = 1024,
                   .torque_constant_nm_per_a = 0.024,
                   .direction = -1.0,
                   .mass_kg = 0.12,
                   .mass_centre_m = 0.1};
  arm.origin_m = Vec3(0.2, 0.01, 0.07);
  return arm;
}

Vec3 random_vector(std::mt19937_64& random, double size) {
  std::uniform_real_distribution<double> uniform(-size, size);
  return {uniform(random), uniform(random), uniform(random)};
}

constexpr double kStep = 1e-6;

template <class Function>
Vec3 numerical_gradient(const Vec3& at, Function&& function) {
  Vec3 gradient;
  for (int n = 0; n < 3; ++n) gradient[n] = (function(at + kStep * Vec3::Unit(n)) - function(at - kStep * Vec3::Unit(n))) / (2.0 * kStep);
  return gradient;
}

TEST(WoodenKinematics, TheRestPoseOf2016IsUprightWithTheLowerArmHangingDown) {
  const WoodenKinematics arm{WoodenArm{}};
  EXPECT_LT((arm.position_m(Vec3::Zero()) - Vec3(-0.22, 0.0, 0.08 + 0.205 - 0.245 - 0.08)).norm(), 1e-12);
}

// 2000 counts are a turn of the motor; the column is 16 times as thick as its capstan, the arms 12 times.
TEST(WoodenKinematics, CountsBecomeAnglesByTheCapstans) {
  const WoodenKinematics arm{WoodenArm{}};
  const Vec3 angles = arm.angles_rad({2000, 2000, -1000});
  EXPECT_NEAR(angles[0], 2.0 * std::numbers::pi / 16.0, 1e-12);
  EXPECT_NEAR(angles[1], 2.0 * std::numbers::pi / 12.0, 1e-12);
  EXPECT_NEAR(angles[2], -std::numbers::pi / 12.0, 1e-12);
  EXPECT_NEAR(WoodenKinematics(odd_arm()).angles_rad({4096, 0, 0})[0], -2.0 * std::numbers::pi * 0.011 / 0.17, 1e-12);
  EXPECT_NEAR(WoodenKinematics(odd_arm()).angles_rad({0, 0, 0})[1], 0.1, 1e-12);
}

TEST(WoodenKinematics, TheUpperArmForwardIsALengthForward) {
  const WoodenKinematics arm{WoodenArm{}};
  const double quarter = 0.5 * std::numbers::pi;
  EXPECT_LT((arm.position_m(Vec3(0, quarter, 0)) - Vec3(0.205 - 0.22, 0, 0.08 - 0.245 - 0.08)).norm(), 1e-12);
  EXPECT_LT((arm.position_m(Vec3(0, 0, quarter)) - Vec3(0.245 - 0.22, 0, 0.205)).norm(), 1e-12);
  EXPECT_LT((arm.position_m(Vec3(quarter, quarter, quarter)) - Vec3(-0.22, 0.45, 0)).norm(), 1e-12);
}

TEST(WoodenKinematics, TheJacobianIsTheDerivativeOfThePosition) {
  std::mt19937_64 random(11);
  for (const WoodenArm& build : {WoodenArm{}, odd_arm()}) {
    const WoodenKinematics arm(build);
    for (int trial = 0; trial < 500; ++trial) {
      const Vec3 angles = random_vector(random, std::numbers::pi);
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3 row = numerical_gradient(angles, [&](const Vec3& at) { return arm.position_m(at)[axis]; });
        ASSERT_LT((arm.jacobian(angles).row(axis).transpose() - row).norm(), 1e-8);
      }
    }
  }
}

TEST(WoodenKinematics, GravityIsTheGradientOfTheEnergy) {
  std::mt19937_64 random(12);
  for (const WoodenArm& build : {WoodenArm{}, odd_arm()}) {
    const WoodenKinematics arm(build);
    for (int trial = 0; trial < 500; ++trial) {
      const Vec3 angles = random_vector(random, std::numbers::pi);
      const Vec3 gradient = numerical_gradient(angles, [&](const Vec3& at) { return arm.potential_energy_j(at); });
      ASSERT_LT((arm.gravity_torque_nm(angles) - gradient).norm(), 1e-7);
    }
  }
}

// The energy uses heights from the kinematics: an arm whose whole mass is at the device point has the energy of that point.
TEST(WoodenKinematics, AMassAtTheDevicePointHasTheEnergyOfItsHeight) {
  WoodenArm build = odd_arm();
  build.bodies[1].mass_kg = 0.0;
  build.bodies[2].mass_kg = 0.5;
  build.bodies[2].mass_centre_m = build.bodies[2].length_m;
  const WoodenKinematics arm(build);
  std::mt19937_64 random(13);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 angles = random_vector(random, std::numbers::pi);
    EXPECT_NEAR(arm.potential_energy_j(angles), 0.5 * 9.80665 * (arm.position_m(angles).z() + build.origin_m.z()), 1e-12);
  }
}

// The motors' power is the hand's power, for any small movement.
TEST(WoodenKinematics, TheMotorsPowerIsTheHandsPower) {
  std::mt19937_64 random(14);
  const WoodenArm build = odd_arm();
  const WoodenKinematics arm(build);
  for (int trial = 0; trial < 500; ++trial) {
    const Vec3 angles = random_vector(random, 1.5), force = random_vector(random, 5.0), speed = random_vector(random, 1.0);
    const Vec3 current = arm.motor_current_a(arm.joint_torque_nm(angles, force));
    double motors_w = 0.0;
    for (std::size_t n = 0; n < 3; ++n) {
      const WoodenArm::Body& body = build.bodies[n];
      const double motor_speed = speed[n] * body.direction * body.body_diameter_m / body.capstan_diameter_m;
      motors_w += body.torque_constant_nm_per_a * current[n] * motor_speed;
    }
    ASSERT_NEAR(motors_w, force.dot(arm.jacobian(angles) * speed), 1e-9);
  }
}

TEST(WoodenKinematics, TheGimbalIsMountedOnTheLowerArm) {
  const WoodenKinematics arm(odd_arm());
  std::mt19937_64 random(15);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 angles = random_vector(random, 1.5);
    WoodenArm shorter = odd_arm();
    shorter.bodies[2].length_m = 0.0;
    const Vec3 along = arm.position_m(angles) - WoodenKinematics(shorter).position_m(angles);
    EXPECT_LT((arm.lower_arm(angles) * -Vec3::UnitZ() - along.normalized()).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace hapton
