#pragma once

#include <cstdint>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// One period: where the device was, the force on it from then on, and what the whole scene gives there without delay.
struct ForceRow {
  Vec3 p_WD = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
  Vec3 zero_delay_n = Vec3::Zero();  // no more than the device can
  double penetration_m = 0.0;  // zero-delay proxy to device
};

// A force held against the one without delay, over a whole touch that begins and ends in free space.
struct ForceComparison {
  double error_rms = 0.0;  // share of the zero-delay force: root of sum |F - F0|^2 / sum |F0|^2
  double error_max_n = 0.0;
  double direction_rms_deg = 0.0;  // between the two, where both are above kLeastN
  double direction_max_deg = 0.0;
  double time_offset_s = 0.0;  // effective_offset.h
  double value_offset = 0.0;   // share of the zero-delay force's RMS
  std::uint64_t falls = 0;     // fall-throughs: times that it began to hold the device by nothing
  double fall_s = 0.0;         // together
  double generated_j = 0.0;    // the most energy that the hand had got in all, so far, at any time: 0 where it had always given more
  double zero_delay_generated_j = 0.0;
  double contact_s = 0.0;  // of the zero-delay force
};

// Fall-through: no force, or one along which the zero-delay one has no share, while the device is deeper than kFallM.
constexpr double kFallM = 0.25e-3;
constexpr double kLeastN = 0.05;

// most_late_s: how late a force may be taken to be. RT: no.
ForceComparison compare_forces(const std::vector<ForceRow>& rows, double period_s, double most_late_s);

}  // namespace hapton
