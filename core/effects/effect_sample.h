#pragma once

#include <cstdint>

#include "core/math/types.h"

namespace hapton {

// What an effect knows of the device at one sample. Frame: S. Units: m, m/s, s. RT: yes.
struct EffectSample {
  Vec3 p_SD = Vec3::Zero();
  Vec3 v_SD = Vec3::Zero();  // smoothed (SmoothVelocity)
  double time_s = 0.0;       // since EffectStep was reset; in most effects with a button, since its last press
};

// What an effect does to the energy of the hand, for a device that is read and driven without delay. Sampling and delay add energy to every
// effect; the governor and the damping of the device bound this energy (docs/loop.md).
enum class Passivity : std::uint8_t {
  conservative,  // the force has a potential: it gives no energy over any closed path
  dissipative,   // it only takes energy
  active         // it can give energy
};

}  // namespace hapton
