#pragma once

#include <cstdint>

#include "safety/safety_limits.h"

namespace hapton {

// Whether the device's samples can be those of a hand, and how it moves.
// A sample is no pose when it is not finite, farther out than 1e6 m or its rotation not of unit length: it is left out. A jump is more than
// max_speed explains, by kJumpM: an encoder lost count; where motors turn the stylus a turn of more than kFastestTurnRadPerS explains by
// kJumpRad, too. After a gap of more than kGapNs a hand may be anywhere, and nothing is a jump.
// Units m, s, rad; frame W. RT: yes.
class MotionWatch {
 public:
  static constexpr double kJumpM = 0.005;
  static constexpr double kJumpRad = 0.2;
  static constexpr double kFastestTurnRadPerS = 50.0;
  static constexpr std::int64_t kGapNs = 100'000'000;
  // The velocity is smoothed over this: a step of an encoder in a single cycle is no speed (1/800 in at 10 kHz would be 0.3 m/s).
  static constexpr double kSmoothS = 0.004;

  enum class Verdict : std::uint8_t { fine, no_pose, jump };

  // Pre: time_ns, that of the sample, never goes back.
  Verdict look(const DeviceSample& sample, std::int64_t time_ns, double max_speed_m_per_s, bool has_torque) noexcept;
  // The next sample begins anew: whatever lies between was not looked at.
  void forget() noexcept { has_begun_ = false; }

  // A good sample no older than kSilenceLimitNs is known.
  bool is_current(std::int64_t now_ns) const noexcept { return has_begun_ && now_ns - time_ns_ < kSilenceLimitNs; }
  const Vec3& p_WD() const noexcept { return p_WD_; }
  const Vec3& velocity_m_per_s() const noexcept { return velocity_m_per_s_; }
  double speed_m_per_s() const noexcept { return speed_m_per_s_; }
  // Between the newest two good samples; zero after a jump.
  const Vec3& moved_m() const noexcept { return moved_m_; }
  // As moved_m: a rotation vector.
  const Vec3& turned_rad() const noexcept { return turned_rad_; }

 private:
  void rest() noexcept;

  Vec3 p_WD_ = Vec3::Zero();
  Quat q_WT_ = Quat::Identity();
  Vec3 moved_m_ = Vec3::Zero();
  Vec3 turned_rad_ = Vec3::Zero();
  Vec3 velocity_m_per_s_ = Vec3::Zero();
  double speed_m_per_s_ = 0.0;
  std::int64_t time_ns_ = 0;
  bool has_begun_ = false;
};

}  // namespace hapton
