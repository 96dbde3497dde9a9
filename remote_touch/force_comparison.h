#pragma once

#include <cstdint>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// One servo period: where the device was, the force on it from then on, and the force that the whole scene gives there without delay.
// Frame: W.
struct ForceRow {
  Vec3 p_WD = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
  Vec3 zero_delay_n = Vec3::Zero();  // limited to the largest force of the device
  double penetration_m = 0.0;        // distance from the zero-delay proxy to the device
};

// Comparison of a force with the one without delay, over a whole touch that begins and ends in free space. Frame: W.
struct ForceComparison {
  double error_rms = 0.0;  // share of the zero-delay force: root of sum |F - F0|^2 / sum |F0|^2
  double error_max_n = 0.0;
  double direction_rms_deg = 0.0;  // angle between the two forces, where both are above kMinN
  double direction_max_deg = 0.0;
  double time_offset_s = 0.0;  // mean delay of the force (effective_offset.h)
  double value_offset = 0.0;   // error that remains without that delay: share of the RMS of the zero-delay force in contact
  std::uint64_t falls = 0;     // number of fall-throughs
  double fall_s = 0.0;         // their total duration
  double generated_j = 0.0;    // the largest net energy that the hand had received at any time; 0 if it had always put in more
  double zero_delay_generated_j = 0.0;
  double contact_s = 0.0;  // total duration of a zero-delay force
};

// Fall-through: no force, or one without a component along the zero-delay force, while the device is deeper than kFallM.
constexpr double kFallM = 0.25e-3;  // 0.25 % of a scene of 100 mm, as in hapton evaluate
constexpr double kMinN = 0.05;      // directions and offsets of smaller forces are not compared; a free choice

// most_late_s: the largest delay that is considered. Each row counts as period_s: a period without a row, in a stall of the machine, adds
// to no duration and no delay. Pre: rows in the order of time, and otherwise period_s apart. RT: no.
ForceComparison compare_forces(const std::vector<ForceRow>& rows, double period_s, double most_late_s);

}  // namespace hapton
