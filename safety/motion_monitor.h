#pragma once

#include <cstdint>

#include "safety/safety_limits.h"

namespace hapton {

// Checks whether the device's samples are plausible for a hand, and filters its velocity.
// Invalid pose: not finite, farther out than 1e6 m, or a quaternion not of unit length; it is ignored. Jump: kJumpM farther than max_speed
// allows, for example because an encoder lost count; on a device with torque also kJumpRad more than kFastestTurnRadPerS allows. After a
// gap of kGapNs or more the hand may be anywhere, and nothing counts as a jump.
// Units m, s, rad; frame W (world), with the device point D and the stylus T. RT: yes.
class MotionMonitor {
 public:
  // The distance that a hand at 3 m/s moves in 1.7 ms, so time stamps may be wrong by that time. A smaller loss of encoder counts is not
  // detected and shifts all walls.
  static constexpr double kJumpM = 0.005;
  // 16 encoder counts, each 1/512 turn, of the gimbals of a PHANToM Model A; a free choice.
  static constexpr double kJumpRad = 0.2;
  // Eight turns a second; a free choice.
  static constexpr double kFastestTurnRadPerS = 50.0;
  // At 3 m/s a hand crosses most of the workspace of a PHANToM Model A in this time.
  static constexpr std::int64_t kGapNs = 100'000'000;
  // Time constant of the velocity filter: without it, one encoder count of 1/800 in within one cycle at 10 kHz would read as 0.3 m/s.
  static constexpr double kSmoothS = 0.004;

  enum class Verdict : std::uint8_t { fine, invalid_pose, jump };

  // Checks a sample and updates position, velocity and motion. An invalid pose only sets the motion to zero; a jump sets the position, and
  // velocity and motion to zero. time_ns: time of the sample. Pre: time_ns never decreases. has_torque: check rotations, too.
  Verdict update(const DeviceSample& sample, std::int64_t time_ns, double max_speed_m_per_s, bool has_torque) noexcept;
  // Restarts with the next sample; the motion up to it does not count.
  void forget() noexcept { has_begun_ = false; }

  // A valid sample younger than kCommandTimeoutNs exists; one that jumped counts.
  bool is_current(std::int64_t now_ns) const noexcept { return has_begun_ && now_ns - time_ns_ < kCommandTimeoutNs; }
  const Vec3& p_WD() const noexcept { return p_WD_; }
  const Vec3& velocity_m_per_s() const noexcept { return velocity_m_per_s_; }
  double speed_m_per_s() const noexcept { return speed_m_per_s_; }
  // Motion between the newest two valid samples, m; zero after a jump or an invalid pose.
  const Vec3& moved_m() const noexcept { return moved_m_; }
  // The rotation between the same samples: its axis times 2 sin(angle / 2), so nearly the rotation vector, rad; zero without torque.
  const Vec3& turned_rad() const noexcept { return turned_rad_; }

 private:
  void set_at_rest() noexcept;

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
