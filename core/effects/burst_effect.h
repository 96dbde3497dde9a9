#pragma once

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"
#include "core/effects/effect_volume.h"
#include "core/effects/waveform.h"

namespace hapton {

// A burst of vibration when the device enters a volume: F = amplitude exp(-t / decay) sin(2 pi frequency t) direction for duration_s after
// the entry, whether the device stays inside or not. An entry during a burst starts it again. With a button (EffectSwitch), a press inside
// starts the burst, and an entry does not. Frame: S. Units: SI. RT: yes. Bound: amplitude_n. Passivity: active; one burst gives at most
// amplitude_n times the path of the hand within duration_s.
struct BurstEffect {
  static constexpr Passivity kPassivity = Passivity::active;

  // What is kept between two samples. A device that is inside at the first sample has not entered.
  struct State {
    bool has_sample = false;
    bool is_inside = false;
    bool has_begun = false;
    double began_s = 0.0;
  };

  Vec3 direction = Vec3::UnitZ();  // unit
  double amplitude_n = 1.0;
  double frequency_hz = 100.0;
  double decay_s = 0.05;    // > 0
  double duration_s = 0.2;  // > 0
  EffectVolume volume = EffectVolume::everywhere();

  double bound_n() const noexcept { return amplitude_n; }

  Vec3 force(const EffectSample& sample, State& state) const noexcept {
    const bool is_inside = volume.contains(sample.p_SD);
    if (is_inside && !state.is_inside && state.has_sample) {
      state.has_begun = true;
      state.began_s = sample.time_s;
    }
    state.has_sample = true;
    state.is_inside = is_inside;
    return burst_force(sample, state);
  }

  // The force of a burst with a button. is_pressed: the button was pressed since the sample before.
  Vec3 force_on_press(const EffectSample& sample, bool is_pressed, State& state) const noexcept {
    if (is_pressed && volume.contains(sample.p_SD)) {
      state.has_begun = true;
      state.began_s = sample.time_s;
    }
    return burst_force(sample, state);
  }

 private:
  Vec3 burst_force(const EffectSample& sample, const State& state) const noexcept {
    const double time_s = sample.time_s - state.began_s;
    if (!state.has_begun || !(time_s < duration_s)) return Vec3::Zero();
    return bounded_force((amplitude_n * decaying_sine(time_s, frequency_hz, decay_s)) * direction, amplitude_n);
  }
};

}  // namespace hapton
