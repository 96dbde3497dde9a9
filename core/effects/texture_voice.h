#pragma once

#include <cstddef>
#include <cstdint>

#include "core/effects/band_limited_signal.h"
#include "core/effects/recorded_texture.h"
#include "core/effects/sample_history.h"

namespace hapton {

// The running signal of a recorded texture. Speed, direction and normal force are smoothed over kSmoothS; the models run at their own rate,
// and BandLimitedSignal reads them at that of the steps, whatever it is: the spectrum is that of the models up to 0.9 of half the lower
// rate. Frame: S. Units: SI. RT: yes. Threads: one.
class TextureVoice {
 public:
  // Of noise in positions, at a speed of some mm/s; the toolkit of the models smooths over as much (20 Hz).
  static constexpr double kSmoothS = 0.008;
  // After a step so long that more samples are due, the others are left out.
  static constexpr int kMaxSamples = 32;

  // The contact begins: silence. The noise goes on.
  void begin() noexcept;
  // The frame is another one: what has the coordinates v has turn * v there.
  void turn(const Mat3& turn) noexcept { velocity_ = turn * velocity_; }
  // normal: unit. pressed_n: along it, at least 0. dt_s: since the sample before; at most 0: the same moment. Pre: texture.is_on(); the
  // others finite.
  Vec3 force(const RecordedTexture& texture, const Vec3& v_SD, const Vec3& normal, double pressed_n, double dt_s) noexcept;

 private:
  void advance(const RecordedTexture& texture, double speed_m_per_s, double dt_s) noexcept;

  SampleHistory accelerations_;  // what the filter of the models gave
  SampleHistory noises_;         // what went into it
  BandLimitedSignal signal_;
  Vec3 velocity_ = Vec3::Zero();  // along the surface
  double pressed_n_ = 0.0;
  double interval_s_ = 0.0;    // between samples
  double since_newest_ = 0.0;  // time in samples of the models
  std::size_t triangle_ = 0;   // of the last blend
  std::uint64_t drawn_ = 0;    // noises so far
  bool is_fresh_ = true;
};

}  // namespace hapton
