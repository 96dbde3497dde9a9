#pragma once

namespace hapton {

// What the passivity of one axis depends on: the device alone, without the hand, which may be any passive one.
struct PassivityCase {
  double period_s = 1e-3;
  double delay_s = 0.0;
  double damping_ns_per_m = 0.0;       // viscous damping of the device
  double amplifier_s = 0.0;            // time constant of the amplifier's first-order lag; 0: no lag
  double friction_n = 0.0;             // Coulomb friction of the device
  double encoder_step_m = 0.0;         // 0: none
  double wall_damping_ns_per_m = 0.0;  // damping of the wall, by finite difference of the position
};

// The largest stiffnesses that generate no energy with any passive hand. Passivity is not stability (stability.h): above them a hand can
// draw energy from the wall, which need not make the loop unstable with a given hand.
struct PassiveStiffness {
  double viscous_n_per_m = 0.0;    // sampling, hold and delay against viscous damping
  double quantised_n_per_m = 0.0;  // encoder steps against Coulomb friction: 2 f_c / step; infinite without steps
  double least_n_per_m() const noexcept { return viscous_n_per_m < quantised_n_per_m ? viscous_n_per_m : quantised_n_per_m; }
};

// Exact for a mass with viscous damping b and a linear wall H(z):
//
//   b > T/2 1/(1 - cos wT) Re{(1 - e^(-jwT)) H(e^(jwT))}   for 0 < w <= pi/T
//
// and, where the delay is not a multiple of T or the amplifier lags, its generalisation: the hand sees every alias of w; the admittance of
// device and hand at each alias lies in the disk with centre and radius 1/(2b); so their weighted sum lies in a disk, too, and the loop
// must keep it clear of -1. For a spring alone that is about K < b / (T/2 + delay). Sources: J. E. Colgate and G. Schenkel, "Passivity of a
// class of sampled-data systems: application to haptic interfaces", J. Robotic Systems 14 (1997); J. J. Abbott and A. M. Okamura, "Effects
// of position quantization and sampling rate on virtual-wall passivity", IEEE Trans. Robotics 21 (2005): K <= min(2b/T, 2 f_c / step), for
// no delay; with delay its second term is used as a necessary condition. A device whose joints bend is passive below these limits, too:
// joints and hand are a passive load of its motor mass. RT: no.
PassiveStiffness find_passive_stiffness(const PassivityCase& loop);

// The largest passive damping (by finite difference) of a wall without stiffness: equal to the device's damping, at any delay. Exact where
// the delay is a multiple of the period: there the condition above is B cos(pi - w (T + delay)) < b, which at w = pi / (T + delay) becomes
// B < b. At other delays on the safe side.
inline double passive_damping_ns_per_m(const PassivityCase& loop) noexcept { return loop.damping_ns_per_m; }

// The linear rule of thumb b / (T/2 + delay), with the damping of device and hand together: near the limit of stability for short delays
// only, wrong by a factor of 7 at 100 ms.
double linear_rule_n_per_m(double damping_ns_per_m, double period_s, double delay_s) noexcept;

}  // namespace hapton
