#pragma once

#include <cstdint>
#include <vector>

#include "closed_loop/loop_simulation.h"

namespace hapton {

// A hand approaches a wall at x = 0 from 5 mm outside, presses with a given force, holds and leaves.
struct PressPlan {
  double press_n = 1.0;  // static force at which it holds
  double speed_m_per_s = 0.1;
  double hold_s = 1.0;
  double after_s = 0.5;          // watched on after it has left; longer than the link takes
  double wall_n_per_m = 1000.0;  // where the hand's intention has to be for that force
};

// The path of the hand. A hand without a spring (off) pushes with press_n, and pulls with the same force to leave.
struct PressPath {
  HandPath path;
  Vec3 start_m = Vec3::Zero();
  std::int64_t release_ns = 0;  // the hold ends
  std::int64_t end_ns = 0;
};
// How far the hand moves beyond the wall for that force; 0: a hand without stiffness, which pushes.
double compute_press_depth_m(const HandModel& hand, const PressPlan& plan);
// Pre: the depth is some metres at most.
PressPath make_press_path(const HandModel& hand, const PressPlan& plan);

// Measurements of a press and release.
struct PressMeasures {
  bool is_bounded = true;      // false: the motion diverged, and the other values are from the time before
  bool has_contact = false;    // a force acted before the release; without one, contact_s is that of the release, and nothing settles
  double contact_s = 0.0;      // first force
  double depth_m = 0.0;        // mean of the last quarter of the hold
  double overshoot = 0.0;      // deepest point beyond depth_m, as a share of it
  double settling_s = 0.0;     // from contact until it stays within 5 % of depth_m, or two encoder steps; infinite: not before the release
  double limit_cycle_m = 0.0;  // half of peak to peak in the last quarter of the hold
  double buzz_hz = 0.0;        // strongest frequency of the force in the second half of the hold
  double buzz_n = 0.0;         // its amplitude
  double wall_j = 0.0;         // work of the motors over press and release: above zero the wall gave energy
  double generated_j = 0.0;    // wall_j less the heat in the device: above zero a passive hand gained energy
  double most_generated_j = 0.0;  // its largest value at any time: above zero the hand had gained energy by then
};

// Pre: rows of one press, samples one period apart. RT: no.
PressMeasures measure_press(const std::vector<LoopRow>& rows, const PressPath& path, std::int64_t period_ns, double encoder_step_m,
                            bool is_bounded);

// A device in a hand, with a link of known faults to the wall.
struct PressCase {
  DeviceModel device;
  HandModel hand;
  std::int64_t period_ns = 1'000'000;
  LinkFaults there = {};
  LinkFaults back = {};
  double wall_damping_ns_per_m = 0.0;
  std::uint64_t seed = 1;
};

// The largest stiffness up to which a press comes to rest: bounded, with a force before the release and a limit cycle of two encoder steps,
// or 1 % of the depth, at most. With encoder steps, friction and saturation, which the limit of stability leaves out. Searched upwards by
// equal ratios, to most_n_per_m, then by bisection to 1 %. RT: no.
double find_rest_stiffness(const PressCase& press, double most_n_per_m);

// A line of a spectrum. Frequency in hertz, amplitude in the signal's unit.
struct SpectrumPeak {
  double frequency_hz = 0.0;
  double amplitude = 0.0;
};
// The lines of a signal's spectrum from the lowest above zero to half of the rate (Hann window, mean taken off). Empty: fewer than 8
// values.
std::vector<SpectrumPeak> compute_spectrum(const std::vector<double>& signal, double rate_hz);
// The strongest of them above lowest_hz.
SpectrumPeak find_spectrum_peak(const std::vector<SpectrumPeak>& spectrum, double lowest_hz);
// Of the force on the motors in the second half of the hold: buzz_hz is the strongest line of it. RT: no.
std::vector<SpectrumPeak> compute_buzz_spectrum(const std::vector<LoopRow>& rows, const PressPath& path, std::int64_t period_ns);

}  // namespace hapton
