#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace hapton {

// Functions of time with values from -1 to 1. RT: yes.
enum class Waveform : std::uint8_t { sine, square, triangle, sawtooth };

// cycles: time times frequency, >= 0. Sine and triangle begin at 0, the square at 1, and the sawtooth at -1, from which it rises.
// Zero where cycles is not finite.
inline double waveform_at(Waveform form, double cycles) noexcept {
  if (!std::isfinite(cycles)) return 0.0;
  const double phase = cycles - std::floor(cycles);
  switch (form) {
    case Waveform::sine:
      return std::sin(2.0 * std::numbers::pi * phase);
    case Waveform::square:
      return phase < 0.5 ? 1.0 : -1.0;
    case Waveform::triangle:
      return phase < 0.25 ? 4.0 * phase : phase < 0.75 ? 2.0 - 4.0 * phase : 4.0 * phase - 4.0;
    case Waveform::sawtooth:
      return 2.0 * phase - 1.0;
  }
  return 0.0;
}

// exp(-time / decay) sin(2 pi frequency time): what a knock on a body sounds like. decay_s > 0. Zero before 0 and where time is not finite.
// Source: Okamura, Cutkosky and Dennerlein, Reality-based models for vibration feedback in virtual environments (2001), eq. 1.
inline double decaying_sine(double time_s, double frequency_hz, double decay_s) noexcept {
  if (!(time_s >= 0.0) || !std::isfinite(time_s)) return 0.0;
  return std::exp(-time_s / decay_s) * waveform_at(Waveform::sine, frequency_hz * time_s);
}

}  // namespace hapton
