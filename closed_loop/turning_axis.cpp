#include "closed_loop/turning_axis.h"

#include <numbers>

#include "closed_loop/recommendation.h"
#include "devices/model_a.h"

namespace hapton {

DeviceModel turning_axis(double max_torque_nm) noexcept {
  constexpr double kStylusKgM2 = 1.5e-4;  // the value of devices/stylus_turn.h, so that this model and the simulated device agree
  return {.mass_kg = kStylusKgM2, .encoder_step_m = 2.0 * std::numbers::pi / model_a::kGimbalCounts, .max_force_n = max_torque_nm};
}

HandModel turning_hand(const HandModel& hand) noexcept {
  constexpr double kSquaredM2 = kGripLeverM * kGripLeverM;
  return {kSquaredM2 * hand.mass_kg, kSquaredM2 * hand.damping_ns_per_m, kSquaredM2 * hand.stiffness_n_per_m};
}

double recommend_rotational_stiffness(const HandModel& hand, double max_torque_nm, double rate_hz, double delay_s) {
  return recommend_stiffness(turning_axis(max_torque_nm), {}, turning_hand(hand), rate_hz, delay_s).stiffness_n_per_m;
}

}  // namespace hapton
