#pragma once

#include <cstdint>

#include "core/math/types.h"

namespace hapton {

// How a stylus with motors on its gimbals turns in a hand: one body, held by a rotational spring and damper to the orientation that the
// hand wants, and turned by the motors' torque.
//
//   I w' = k_h turn(q -> q_h) - b_h w + torque
//
// No data sheet or study that we know of says how stiffly a hand holds a stylus against turning; the numbers are those of StylusModel's
// grip at a lever of 5 cm, and a stylus of 40 g and 20 cm. One step of semi-implicit Euler each 100 us of the device's time: the trajectory
// does not depend on how often it is read. Frame W, SI. RT: advance yes.
class StylusTurn {
 public:
  static constexpr double kInertiaKgM2 = 1.5e-4;
  static constexpr double kHandNmPerRad = 1.0;
  static constexpr double kHandNmSPerRad = 0.015;
  static constexpr std::int64_t kStepNs = 100'000;

  // Both times >= 0, of the device.
  void advance(std::int64_t from_ns, std::int64_t to_ns, const Quat& q_WH, const Vec3& torque_nm) noexcept;
  // Before the first advance.
  void begin_at(const Quat& q_WT) noexcept { q_WT_ = q_WT; }
  const Quat& q_WT() const noexcept { return q_WT_; }

 private:
  Quat q_WT_ = Quat::Identity();
  Vec3 w_rad_per_s_ = Vec3::Zero();
};

}  // namespace hapton
