#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "bench/measure/step_times.h"
#include "core/base/result.h"
#include "core/force/evaluation/force_error.h"
#include "core/force/force_method.h"
#include "core/geometry/touch_trajectory.h"

namespace hapton {

constexpr double kSphereRadiusM = 0.0005;  // probe radius of the measurements with a sphere
constexpr std::uint32_t kSetSize = 64;     // triangles of a local set, as in the FDH paper

// The cost of the whole haptic step (core/force/touch_step.h, as in the live node) with a method along a trajectory.
struct MethodTiming {
  TimeSpread all, contact, free;  // spreads of the least times of the steps over all repetitions
  double mean_ns = 0.0;           // mean over all steps, without reading the clock in between; 0: there was no time for it
  int repetitions = 0;
  double build_ms = 0.0;           // time of make_method, called once
  std::size_t bytes = 0;           // growth of the heap while the method was made
  std::vector<ForceSample> felt;   // forces in the last repetition
  std::vector<double> contact_ns;  // the least time of each contact step
};

// RT: set-up only. Error: that of make_method.
Result<MethodTiming> time_method(const Stopwatch& watch, const TimingBudget& budget, const MethodSettings& settings,
                                 const TouchScene& scene, const TouchTrajectory& trajectory);

// The method's forces along the trajectory, untimed. Error: that of make_method.
Result<std::vector<ForceSample>> compute_forces(const MethodSettings& settings, const TouchScene& scene, const TouchTrajectory& trajectory);

// The first `rows` rows of every piece between two resets: a method gives the same forces on them as on the whole trajectory.
TouchTrajectory take_heads(const TouchTrajectory& trajectory, std::size_t rows);

// The output of method `reference` along a trajectory, with which compare_forces compares other methods.
struct ReferenceRun {
  TouchTrajectory trajectory;
  std::vector<ForceSample> felt;
  std::string description;  // what the reference did: its sub-steps and how many steps settled
  TimeSpread time;          // times of its contact steps in one repetition
  double extent_m = 0.0;
  double stiffness_n_per_m = 0.0;

  // Compares a method's output along `trajectory` with the reference.
  ForceError compare(const std::vector<ForceSample>& felt_by_method) const;

 private:
  ForceErrorSettings error_settings() const;
};

// Takes the effects of the scene into account, as compute_forces. Pre: the scene has an object, and none that moves. Error: as make_method.
Result<ReferenceRun> run_reference(const Stopwatch& watch, const TouchScene& scene, const TouchTrajectory& trajectory,
                                   double probe_radius_m);

}  // namespace hapton
