#pragma once

#include "core/math/types.h"

namespace hapton {

// Passivity observer and controller for contact forces: over any time the device gives the hand no more energy than the hand has put in,
// whatever the wall's stiffness, the delay and the losses in between. The SafetyGovernor runs it after a call of keep_passive().
//
//   observer     given += mean force on the motors since the last sample . motion since then. This is exact for a force that is held.
//                given -= what the device's own damping and friction dissipate. So a wall of stiffness K that the damping b makes passive
//                (b > K T / 2, T: the period) is left as it is.
//                given += half an encoder step . change of force: a position that is rounded may hide this much.
//                -given is the energy that the hand has put in and not got back: the credit.
//   controller   in one period T a force f along the motion of a free mass m at velocity v gives f (v T + f T^2 / 2 m). The largest f that
//                gives no more than the credit is allowed. Springs below m / T^2 pass unchanged: a spring stores f^2 / 2 k.
//   deficit      a hand that pulls the device away moves it farther than a free mass. The excess given by that is taken back: the bound
//                allows only a force that gets energy back, and the motion is damped, also without contact.
//
// Without force on the motors the credit is dropped, and a deficit stays: contacts do not lend to each other. Effects that are a source by
// intent (a moving object, a spring that is switched on while it is extended) lose their force: they cannot be used with this controller.
//
// Sources: Hannaford and Ryu, "Time-domain passivity control of haptic interfaces", IEEE Trans. Robotics and Automation 18 (2002); the
// observer by displacements: Stramigioli et al., "Sampled data systems passivity and discrete port-Hamiltonian systems", IEEE Trans.
// Robotics 21 (2005); limiting the force: Kim and Ryu, "Robustly stable haptic interaction control using an energy-bounding algorithm",
// Int. J. Robotics Research 29 (2010). We bound by the credit and the next displacement of the least mass, and damp only a deficit.
// Units J, N, m, s, kg; frame W. RT: yes.
class PassivityController {
 public:
  // The device without a hand. A value that is not known is 0, which is safe; only the mass must be known: the least that the motors can
  // have to accelerate.
  struct Mechanics {
    double mass_kg = 0.0;
    double damping_ns_per_m = 0.0;
    double friction_n = 0.0;
    double position_step_m = 0.0;  // resolution of its encoders at the tip; 0: positions are exact
  };

  // Times max_force: the largest credit that is kept. A spring that stores more would have to be softer than max_force / 4 cm.
  static constexpr double kMaxCreditM = 0.020;

  // Samples over which dissipation is estimated by the motion from the first to the last: noise of the encoder, which goes to and fro, adds
  // nothing.
  static constexpr int kWindow = 8;

  // Pre: mass above 0, damping and friction 0 or more.
  explicit PassivityController(const Mechanics& device) noexcept : device_(device) {}

  // force_n was on the motors for passed_s.
  void note_applied(const Vec3& force_n, double passed_s) noexcept;
  // A sample: the device has moved by moved_m since the sample before.
  void observe(double max_force_n, const Vec3& moved_m) noexcept;

  // The force to write in place of wanted_n until the next sample. most_damping: the damping that the device bears, N s / m.
  Vec3 shape(const Vec3& wanted_n, double most_damping) noexcept;

  // Energy given, J. Above 0: a deficit. Below 0: a credit of that size.
  double given_j() const noexcept { return given_j_; }
  // The last force was lower than wanted, or damped.
  bool has_limited() const noexcept { return has_limited_; }

 private:
  double largest_allowed_n(const Vec3& direction) const noexcept;
  double take_dissipated_j(const Vec3& moved_m) noexcept;

  Mechanics device_;
  Vec3 force_n_s_ = Vec3::Zero();  // since the last sample
  double passed_s_ = 0.0;
  double period_s_ = 0.0;                      // between the last two samples
  Vec3 mean_velocity_m_per_s_ = Vec3::Zero();  // between the last two samples
  Vec3 mean_force_n_ = Vec3::Zero();
  Vec3 window_moved_m_ = Vec3::Zero();
  double window_s_ = 0.0;
  int window_samples_ = 0;
  double given_j_ = 0.0;
  bool has_limited_ = false;
};

}  // namespace hapton
