#pragma once

#include <cstdint>

#include "core/math/types.h"

namespace hapton {

// How a stylus with motors on its gimbals turns in a hand: one body, held by a rotational spring and damper to the orientation that the
// hand wants, and turned by the motors' torque.
//
//   I w' = k_h turn(q -> q_h) - b_h w + torque
//
// No data sheet or study that we know of says how stiffly a hand holds a stylus against turning. Stiffness and damping are those of
// StylusModel's hand at a lever of 5 cm; the hand's mass is left out. The inertia is that of a uniform rod of 40 g and 20 cm about a grip
// 2 cm from its centre. One step of semi-implicit Euler each 100 us of the device's time: with a constant torque and hand the trajectory
// does not depend on how often it is read. Frame W (world), SI; q_WT: orientation of the stylus, q_WH: the one that the hand wants. RT:
// advance yes.
class StylusTurn {
 public:
  static constexpr double kInertiaKgM2 = 1.5e-4;  // 1.33e-4 about the centre, 0.16e-4 for the 2 cm
  static constexpr double kHandNmPerRad = 1.0;
  static constexpr double kHandNmSPerRad = 0.015;
  static constexpr std::int64_t kStepNs = 100'000;

  // Advances the turn from one time of the device to a later one. Pre: 0 <= from_ns <= to_ns.
  void advance(std::int64_t from_ns, std::int64_t to_ns, const Quat& q_WH, const Vec3& torque_nm) noexcept;
  // Sets the orientation at the start. To be called before the first advance().
  void begin_at(const Quat& q_WT) noexcept { q_WT_ = q_WT; }
  const Quat& q_WT() const noexcept { return q_WT_; }

 private:
  Quat q_WT_ = Quat::Identity();
  Vec3 w_rad_per_s_ = Vec3::Zero();
};

}  // namespace hapton
