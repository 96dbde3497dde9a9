#pragma once

#include <cstddef>
#include <cstdint>

#include "core/effects/band_limited_signal.h"
#include "core/effects/recorded_texture.h"
#include "core/effects/sample_history.h"

namespace hapton {

// The running signal of a recorded texture. Speed, direction and normal force are smoothed over kSmoothS; the models run at their own rate,
// and BandLimitedSignal reads them at that of the steps, whatever it is: the spectrum is that of the models up to 0.74 to 0.99 of half the
// lower rate, depending on the ratio of the rates. Frame: S. Units: SI. RT: yes. Threads: one.
class TextureVoice {
 public:
  // Smooths noise of positions at speeds of some mm/s; the toolkit of the models smooths over as much (20 Hz).
  static constexpr double kSmoothS = 0.008;
  // Smooths the time between steps, which determines the stride and the delay of the signal: a step that is late must not change them.
  static constexpr double kIntervalS = 0.25;
  // Most samples of the models in one step. After a step so long that more are due, the others are left out.
  static constexpr int kMaxSamples = 32;

  // Called when the contact begins: the signal starts from silence; the noise and the time between steps go on.
  void begin() noexcept;
  // Changes the frame of v_SD and normal: a vector with the coordinates v in the frame before has turn * v in the new one.
  void turn(const Mat3& turn) noexcept { velocity_ = turn * velocity_; }
  // The force at the next sample. normal: unit. pressed_n: force along it, at least 0. dt_s: time since the sample before; at most 0: the
  // same moment. Pre: texture.is_on(); the others finite.
  Vec3 force(const RecordedTexture& texture, const Vec3& v_SD, const Vec3& normal, double pressed_n, double dt_s) noexcept;

 private:
  void advance(const RecordedTexture& texture, double speed_m_per_s, double dt_s) noexcept;

  SampleHistory accelerations_;  // output of the models' filter
  SampleHistory noises_;         // input of the models' filter
  BandLimitedSignal signal_;
  Vec3 velocity_ = Vec3::Zero();  // along the surface
  double pressed_n_ = 0.0;
  double interval_s_ = 0.0;        // smoothed time between steps
  double since_newest_ = 0.0;      // time since the newest sample of the models, in their samples
  std::size_t triangle_ = 0;       // triangle of the last blend
  std::uint64_t noise_count_ = 0;  // number of noise samples so far
  bool is_fresh_ = true;
};

}  // namespace hapton
