#pragma once

#include <cstdint>
#include <vector>

#include "closed_loop/loop_simulation.h"

namespace hapton {

// A hand approaches a wall at x = 0 from 5 mm outside, presses with a given force, holds and leaves.
struct PressPlan {
  double press_n = 1.0;  // static force on the wall during the hold
  double speed_m_per_s = 0.1;
  double hold_s = 1.0;
  double after_s = 0.5;          // simulated time after the hand has left; longer than the delay of the link
  double wall_n_per_m = 1000.0;  // stiffness of the wall, from which follows how far behind its surface the goal of the hand has to be
};

// The path of the hand, frame W. A hand without a spring (preset off) pushes with the force press_n, and pulls with the same force to
// leave.
struct PressPath {
  HandPath path;
  Vec3 start_m = Vec3::Zero();
  std::int64_t release_ns = 0;  // end of the hold
  std::int64_t end_ns = 0;
};
// How far behind the surface of the wall the goal of the hand (p_WH) has to be for press_n; 0: a hand without a spring, which pushes.
double compute_press_depth_m(const HandModel& hand, const PressPlan& plan);
// Pre: compute_press_depth_m(hand, plan) is at most a few metres.
PressPath make_press_path(const HandModel& hand, const PressPlan& plan);

// Measurements of a press and release.
struct PressMeasures {
  bool is_bounded = true;         // false: the motion diverged; the other values are from the time before that
  bool has_contact = false;       // a force acted before the release; false: settling_s is infinite
  double contact_s = 0.0;         // time of the first force, which may be after the release; no force: time of the release
  double depth_m = 0.0;           // mean of the last quarter of the hold
  double overshoot = 0.0;         // deepest point beyond depth_m, as a share of depth_m
  double settling_s = 0.0;        // from contact until x stays within the larger of 5 % of depth_m and two encoder steps; infinite: never
  double limit_cycle_m = 0.0;     // half of the peak-to-peak motion in the last quarter of the hold
  double buzz_hz = 0.0;           // strongest frequency, 5 Hz or more, of the force in the second half of the hold
  double buzz_n = 0.0;            // amplitude of the force at buzz_hz
  double wall_j = 0.0;            // work of the motors over press and release: above zero the wall gave energy
  double generated_j = 0.0;       // wall_j less the heat in the device: above zero a passive hand gained energy
  double most_generated_j = 0.0;  // largest generated_j at any time: above zero the hand had gained energy by then

  // Whether the limit cycle is at most two encoder steps or 1 % of the depth, whichever is larger. RT: yes.
  bool is_still(double encoder_step_m) const noexcept;
};

// Pre: rows are those of one press, with samples one period apart. RT: no.
PressMeasures measure_press(const std::vector<LoopRow>& rows, const PressPath& path, std::int64_t period_ns, double encoder_step_m,
                            bool is_bounded);

// A device in a hand, and the link to the wall with its faults.
struct PressCase {
  DeviceModel device;
  HandModel hand;
  std::int64_t period_ns = 1'000'000;
  LinkFaults to_law = {};
  LinkFaults from_law = {};
  double wall_damping_ns_per_m = 0.0;
  std::uint64_t seed = 1;
};

// The largest stiffness up to which a press comes to rest: its motion is bounded, there is a force before the release, and it is still
// (PressMeasures::is_still). Unlike the limit of stability, it includes encoder steps, friction and saturation. Searched upwards in equal
// ratios up to most_n_per_m, then by bisection to 1 %. RT: no.
double find_rest_stiffness(const PressCase& press, double most_n_per_m);

// A line of a spectrum. The amplitude has the unit of the signal.
struct SpectrumPeak {
  double frequency_hz = 0.0;
  double amplitude = 0.0;
};
// The lines of a signal's spectrum, from the lowest frequency above zero to half of the sampling rate (Hann window, mean subtracted).
// Empty: fewer than 8 values.
std::vector<SpectrumPeak> compute_spectrum(const std::vector<double>& signal, double rate_hz);
// The strongest line at lowest_hz or above.
SpectrumPeak find_spectrum_peak(const std::vector<SpectrumPeak>& spectrum, double lowest_hz);
// The spectrum of the force on the motors in the second half of the hold; buzz_hz is its strongest line from 5 Hz up. RT: no.
std::vector<SpectrumPeak> compute_buzz_spectrum(const std::vector<LoopRow>& rows, const PressPath& path, std::int64_t period_ns);

}  // namespace hapton
