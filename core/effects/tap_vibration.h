#pragma once

#include <algorithm>

#include "core/effects/bounded_force.h"
#include "core/effects/effect_sample.h"
#include "core/effects/waveform.h"

namespace hapton {

// The ring of a hard surface that is tapped: F = a v exp(-t / decay) sin(2 pi frequency t) along the contact normal, v the speed of the
// impact and t the time since, while the contact lasts. Units: SI. RT: yes. Bound: max_force_n. Passivity: active; one tap gives at most
// max_force_n times the path of the hand while it rings, about 3 decay_s. Source: Okamura, Cutkosky and Dennerlein (2001), Reality-based
// models for vibration feedback in virtual environments: metal rings near 300 Hz, wood near 100 Hz, rubber near 30 Hz.
struct TapVibration {
  static constexpr Passivity kPassivity = Passivity::active;

  struct State {
    double amplitude_n = 0.0;
    double began_s = 0.0;
  };

  double ns_per_m = 0.0;  // a, amplitude for each m/s of the impact; 0: off
  double frequency_hz = 100.0;
  double decay_s = 0.02;  // > 0
  double max_force_n = 2.0;

  bool is_on() const noexcept { return ns_per_m > 0.0; }
  double bound_n() const noexcept { return max_force_n; }

  // Called when the contact begins. inward_m_per_s: speed of the device into the surface; one that moves outwards causes no ring.
  void begin(double inward_m_per_s, double time_s, State& state) const noexcept {
    state = {.amplitude_n = std::clamp(ns_per_m * inward_m_per_s, 0.0, max_force_n), .began_s = time_s};
  }
  // The force along the contact normal, outwards positive.
  double force(double time_s, const State& state) const noexcept {
    return state.amplitude_n > 0.0 ? state.amplitude_n * decaying_sine(time_s - state.began_s, frequency_hz, decay_s) : 0.0;
  }
};

}  // namespace hapton
