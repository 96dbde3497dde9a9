#pragma once

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"
#include "core/effects/effect_volume.h"
#include "core/effects/waveform.h"

namespace hapton {

// A force that varies with time, in a volume: F = amplitude w(frequency t) direction, w of period 1, |w| <= 1. Frame: S. Units: SI.
// RT: yes. Bound: amplitude_n. Passivity: active; its power is at most amplitude_n times the speed of the hand.
struct WaveEffect {
  static constexpr Passivity kPassivity = Passivity::active;

  Waveform waveform = Waveform::sine;
  Vec3 direction = Vec3::UnitZ();  // unit
  double amplitude_n = 0.5;
  double frequency_hz = 10.0;
  EffectVolume volume = EffectVolume::everywhere();

  double bound_n() const noexcept { return amplitude_n; }
  Vec3 force(const EffectSample& sample) const noexcept {
    if (!volume.contains(sample.p_SD)) return Vec3::Zero();
    return bounded_force((amplitude_n * waveform_at(waveform, frequency_hz * sample.time_s)) * direction, amplitude_n);
  }
};

}  // namespace hapton
