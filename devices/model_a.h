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

// What the memo does not say is the later Premium 1.5's, the same machine: 1.4 N are its data sheet's "continuous exertable force". How
// long the peak may last is in no data sheet; 10 s make a time constant of six minutes, between a winding's and a motor's.
constexpr double kContinuousForceN = 1.4;
constexpr double kPeakS = 10.0;

// Twice what an arm does in earnest.
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

// With motors on the gimbals, as the later Premium 1.5/6DOF: its data sheet gives 0.515 Nm for yaw and pitch and 0.17 Nm for roll at most;
// one ball of torque stays below all three.
constexpr double kMaxTorqueNm = 0.17;

inline DeviceLimits limits_with_torque() {
  DeviceLimits limits = model_a::limits();
  limits.max_torque_nm = kMaxTorqueNm;
  limits.max_torque_slew_nm_per_s = kMaxTorqueNm / kForceRiseS;
  return limits;
}

}  // namespace model_a
}  // namespace hapton
