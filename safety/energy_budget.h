#pragma once

#include "safety/safety_limits.h"

namespace hapton {

// Passivity observer and controller: measures how much more energy the device has given to the hand than it took, and limits that.
//
//   spent += mean force on the motors since the last sample . motion since then  (and torque . turn)
//   spent -= kForgivenMPerS x max_force each second, the energy that sampling and delay add at any wall; never below -kFreeM x max_force
//
// Up to kFreeM x max_force the budget does nothing: springs and friction of a normal contact stay far below. Above, damping dissipates
// the excess within kTakeBackS, and the force limit decreases with the energy spent: at kMaxM x max_force it is zero. So over any time t
// even an active source gives no more than
//
//   (kFreeM + kMaxM + kForgivenMPerS t) max_force + the energy that it gives while its last force is released.
//
// Source: Hannaford and Ryu, "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics and Automation 18 (2002). We
// differ: their damper dissipates all excess in the next sample, which is felt as a blow; ours takes kTakeBackS, within the device's stable
// damping. Their observer accumulates dissipated energy without bound, which hides a source that becomes active late; ours is bounded. What
// damping cannot dissipate, the lower force limit prevents. Units J, N, m, s, frame W. RT: yes.
class EnergyBudget {
 public:
  // Lengths and a speed, to be multiplied by max_force, so that a weak and a strong device feel the same (decision 50).
  // In tests a hand that pressed, slid and tapped at 1000 N/m, with replies up to 5 ms late, never spent anything. A smaller value damps
  // unstable walls earlier; a larger one lets them buzz.
  static constexpr double kFreeM = 0.010;
  // 0.25 J for a PHANToM Model A: a tenth of the energy that the device could give in one stroke through its workspace.
  static constexpr double kMaxM = 0.030;
  // Power that sampling and delay add at any wall. A source may give this power for ever: 17 mW for a Model A.
  static constexpr double kForgivenMPerS = 0.002;
  // Time in which the excess is dissipated. In one sample, as in the paper, this would be felt as a blow; 5 ms is a free choice.
  static constexpr double kTakeBackS = 0.005;
  // The energy spent saturates here. With kForgivenMPerS the limit rises again 3 s after a source has ended, and has its full value after
  // 13 s.
  static constexpr double kSaturationM = 0.036;

  // The wrench was on the motors for passed_s.
  void note_applied(const Wrench& wrench, double passed_s) noexcept {
    force_n_s_ += passed_s * wrench.force_n;
    torque_nm_s_ += passed_s * wrench.torque_nm;
    passed_s_ += passed_s;
  }
  // A sample: the device has moved and turned by this since the sample before. wrench: on the motors now, used if no time has passed.
  void observe(double max_force_n, const Wrench& wrench, const Vec3& moved_m, const Vec3& turned_rad) noexcept;

  double spent_j() const noexcept { return spent_j_; }
  // Energy spent up to which the budget does nothing, and from which on the force limit is zero.
  static double free_j(double max_force_n) noexcept { return kFreeM * max_force_n; }
  static double most_j(double max_force_n) noexcept { return kMaxM * max_force_n; }

  // Damping that dissipates the excess within kTakeBackS at this speed, N s / m, at most `most`; 0 without an excess.
  double damping_n_s_per_m(double max_force_n, double speed_m_per_s, double most) const noexcept;
  // Share of max_force_n that is allowed: 1 up to free_j, 0 from most_j on.
  double share(double max_force_n) const noexcept;

 private:
  Vec3 force_n_s_ = Vec3::Zero();
  Vec3 torque_nm_s_ = Vec3::Zero();
  double passed_s_ = 0.0;
  double spent_j_ = 0.0;
};

}  // namespace hapton
