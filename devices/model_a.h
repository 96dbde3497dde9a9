#pragma once

#include "devices/device.h"

namespace hapton {

// The PHANToM Model A of the 1996 HP memo, "Hardware Description": work space 7.5 x 10.5 x 15 in, 1.9 lbf at most, positions to
// 1/800 in, gimbals to 1/512 turn. The memo does not say which side of the work space is which: x (right) takes 10.5 in, y (up) 7.5
// in, z (to the user) 15 in, centred on the origin.
namespace model_a {

constexpr double kInchM = 0.0254;
constexpr double kPositionStepM = kInchM / 800.0;
constexpr int kGimbalCounts = 512;
constexpr double kMaxForceN = 1.9 * 4.4482216152605;  // 1.9 lbf

// Not in the memo; from the later Premium 1.5, the same machine: its data sheet gives 1.4 N as "continuous exertable force". No data sheet
// says how long the peak force may last. 10 s correspond to a thermal time constant of six minutes, between those of a winding and of a
// motor.
constexpr double kContinuousForceN = 1.4;
constexpr double kPeakS = 10.0;

// About twice the speed of fast arm movements. A choice.
constexpr double kMaxSpeedMPerS = 3.0;

constexpr double kMaxSlewNPerS = kMaxForceN / kForceRiseS;

inline DeviceLimits limits() {
  const Vec3 half = 0.5 * kInchM * Vec3(10.5, 7.5, 15.0);
  return {.max_force_n = kMaxForceN,
          .max_slew_n_per_s = kMaxSlewNPerS,
          .max_stiffness_n_per_m = 1000.0,
          .workspace_min_m = -half,
          .workspace_max_m = half,
          .continuous_force_n = kContinuousForceN,
          .peak_s = kPeakS,
          .max_speed_m_per_s = kMaxSpeedMPerS};
}

// Largest torque with motors on the gimbals, as in the later Premium 1.5/6DOF: its data sheet gives at most 0.515 Nm for yaw and pitch and
// 0.17 Nm for roll. The limit on the magnitude is the smallest of the three.
constexpr double kMaxTorqueNm = 0.17;

inline DeviceLimits limits_with_torque() {
  DeviceLimits limits = model_a::limits();
  limits.max_torque_nm = kMaxTorqueNm;
  limits.max_torque_slew_nm_per_s = kMaxTorqueNm / kForceRiseS;
  return limits;
}

}  // namespace model_a
}  // namespace hapton
