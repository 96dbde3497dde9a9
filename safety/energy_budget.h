#pragma once

#include "safety/safety_limits.h"

namespace hapton {

// The passivity observer and its controller: how much more energy the device has given to the hand than it took, and what is done about it.
//
//   spent += mean force on the motors since the last sample . motion since then  (and torque . turn)
//   spent -= kForgivenMPerS x max_force each second, for what sampling and delay cost any wall; never below -kFreeM x max_force
//
// Up to kFreeM x max_force nothing is done: the springs and rubs of a normal contact stay far below it. Above, damping takes the excess
// back within kTakeBackS; the force allowed sinks with what is spent, and at kMostM x max_force nothing is left of it. So over any time t a
// source, however active, gives no more than
//
//   (kFreeM + kMostM + kForgivenMPerS t) max_force + what it gives while its last force is let go.
//
// Source: Hannaford and Ryu, "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics and Automation 18 (2002). We
// differ: their damper takes all excess back in the next sample, which is felt as a blow, ours in kTakeBackS, and no stronger than the
// device bears; their observer saves up without end what rubbing takes, so that a source that becomes active late is unseen for long: ours
// keeps no more than a press; and what damping cannot hold, the sinking force does. Units J, N, m, s, frame W. RT: yes.
class EnergyBudget {
 public:
  static constexpr double kFreeM = 0.010;
  static constexpr double kMostM = 0.030;
  static constexpr double kForgivenMPerS = 0.002;
  static constexpr double kTakeBackS = 0.005;
  static constexpr double kSaturationM = 0.036;  // more is not remembered, so that it is not punished for minutes

  // The wrench was on the motors for passed_s.
  void held(const Wrench& wrench, double passed_s) noexcept {
    force_n_s_ += passed_s * wrench.force_n;
    torque_nm_s_ += passed_s * wrench.torque_nm;
    passed_s_ += passed_s;
  }
  // A sample: the device has moved by this since the one before. wrench: on the motors now.
  void observe(double max_force_n, const Wrench& wrench, const Vec3& moved_m, const Vec3& turned_rad) noexcept;

  double spent_j() const noexcept { return spent_j_; }
  // Above what is free: 0 and less is none.
  static double free_j(double max_force_n) noexcept { return kFreeM * max_force_n; }
  static double most_j(double max_force_n) noexcept { return kMostM * max_force_n; }

  // N s / m at this speed, no more than `most`.
  double damping_n_s_per_m(double max_force_n, double speed_m_per_s, double most) const noexcept;
  // What is allowed of max_force_n.
  double share(double max_force_n) const noexcept;

 private:
  Vec3 force_n_s_ = Vec3::Zero();
  Vec3 torque_nm_s_ = Vec3::Zero();
  double passed_s_ = 0.0;
  double spent_j_ = 0.0;
};

}  // namespace hapton
