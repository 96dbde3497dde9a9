#pragma once

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "closed_loop/loop_simulation.h"

namespace hapton {

// How the motion between two samples is computed: exactly, event by event (axis_motion.h), or in steps as simulators do.
enum class Integrator : std::uint8_t { exact, runge_kutta, semi_implicit_euler };
std::string_view to_string(Integrator integrator) noexcept;

// Moves one axis in equal steps, for comparison with AxisMotion. Friction opposes the velocity at each step's beginning; where the velocity
// would change its sign within the step, the mass stops, and breaks away when the other forces exceed friction. Units SI, ns. RT: no.
class SteppedMotion {
 public:
  // Pre: integrator is not exact; step_ns > 0.
  SteppedMotion(const DeviceModel& device, const HandModel& hand, Integrator integrator, std::int64_t step_ns);

  // Pre: duration_ns is a multiple of the step_ns given above.
  void advance(AxisMotion::StateVector& state, const AxisMotion::Input& input, std::int64_t duration_ns) const noexcept;

 private:
  AxisMotion::StateVector rate(const AxisMotion::StateVector& state, const AxisMotion::Input& input, double since_s,
                               double friction_n) const noexcept;
  void step(AxisMotion::StateVector& state, const AxisMotion::Input& input, double since_s) const noexcept;
  bool remains_at_rest(const AxisMotion::StateVector& state, const AxisMotion::Input& input, double since_s) const noexcept;

  AxisPlant plant_;
  double friction_n_;
  Integrator integrator_;
  std::int64_t step_ns_;
};

// A comparison of integrators: a hand that presses on a wall. period_ns: period of the samples.
struct IntegratorCase {
  DeviceModel device;
  HandModel hand;
  std::int64_t period_ns = 1'000'000;
  double wall_n_per_m = 1000.0;
  double seconds = 0.5;
};

// The positions of the device at the samples when a hand presses into the same one-sided wall at 0.2 m/s, up to an intended position 10 mm
// below the surface. Pre: step_ns > 0; unless integrator is exact, period_ns is a multiple of it.
std::vector<double> run_press(const IntegratorCase& press, Integrator integrator, std::int64_t step_ns);

// The largest difference of two runs, up to the end of the shorter one.
double worst_difference(std::span<const double> run, std::span<const double> reference) noexcept;

}  // namespace hapton
