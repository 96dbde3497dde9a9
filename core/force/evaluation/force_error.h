#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// The result of one method in one step. Frame W or S, SI.
struct ForceSample {
  Vec3 device = Vec3::Zero();
  Vec3 proxy = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
  bool settled = true;  // of the reference; false: finer sub-steps still changed its force
};

struct ForceErrorSettings {
  double stiffness_n_per_m = 1000.0;
  double extent_m = 0.1;        // longest side of the object; the thresholds of fall-through, false contact and stuck scale with it
  std::size_t reset_every = 0;  // steps from one reset to the next, none compared across a reset; 0: no resets
};

// RMS, quantiles and maximum of one quantity. All zero if it has no values.
struct ErrorSpread {
  std::size_t count = 0;
  double rms = 0.0, p50 = 0.0, p99 = 0.0, most = 0.0;
};

// An episode of consecutive contact steps in which the method's force differs from the reference's by more than
// ForceError::kBranchShare. Its cause is the first in the order of Cause that applies.
struct BranchSwitch {
  enum class Cause {
    unconverged,  // with every step converged there is no such error: the proxy had not reached its local minimum
    unsettled,    // in its first step the reference has not settled, so the true force is not known
    unexplained,  // neither: mostly different local minima (decision 242)
  };
  std::size_t first_step = 0;
  std::size_t steps = 0;
  double most = 0.0;  // largest relative error, as a share of |F_ref|
  Cause cause = Cause::unexplained;
};

// The error of a method against the reference.
//
// Relative error |F - F_ref| / |F_ref| over every step in which the reference has a force and the method's output is finite; the angle
// between the two over those of them in which the method has a force as well.
// A branch switch is an episode of consecutive contact steps in which the method's force differs from the reference by more than
// kBranchShare: mostly the method is in another local minimum. All its steps count as errors, however long it lasts; it ends at a step with
// a smaller error, without contact or not finite, and at a reset. Episodes and their steps are counted in addition.
struct ForceError {
  // A choice, far above 1e-6, to which `proxy` agrees with the reference in the same local minimum (decision 80).
  static constexpr double kBranchShare = 0.01;

  std::size_t steps = 0;
  std::size_t contact_steps = 0;    // with a force of the reference
  std::size_t unsettled_steps = 0;  // contact steps in which the reference has not settled; they count like all others
  ErrorSpread error;                // |F - F_ref| / |F_ref|
  ErrorSpread direction_rad;
  std::size_t branch_switches = 0;     // episodes
  std::size_t switched_steps = 0;      // in all episodes
  std::vector<BranchSwitch> switches;  // the episodes in order
  std::size_t fall_throughs = 0;       // the method is free while the reference is deeper than 0.25 % of the extent
  std::size_t false_contacts = 0;      // the method is deeper than 0.25 % of the extent while the reference is free
  std::size_t stuck_steps = 0;         // the method's proxy is more than 10 % of the extent farther from the device than the reference's
  std::size_t discontinuities = 0;     // |dF| above 2 k |dx| plus the reference's largest |dF| in this step and its neighbours
  double worst_discontinuity_n = 0.0;  // largest excess over that bound
  std::size_t not_finite = 0;
  std::size_t worst_step = 0;  // step with the largest relative error

  std::size_t count(BranchSwitch::Cause cause) const;
  // Steps with a fall-through, false contact, stuck proxy, force discontinuity or a force that is not finite.
  std::size_t faults() const { return fall_throughs + false_contacts + stuck_steps + discontinuities + not_finite; }
};

// Compares a method with the reference step by step on the same trajectory. `converged`: the same method, each step converged before
// the next sample; empty: not known, and no switch is called unconverged. Only BranchSwitch::cause depends on it: a switch is
// unconverged if the converged force is within kBranchShare of the reference in all its steps. Pre: equal lengths. RT: set-up only.
ForceError compare_forces(std::span<const ForceSample> method, std::span<const ForceSample> reference, const ForceErrorSettings& settings,
                          std::span<const ForceSample> converged = {});

// RMS and quantiles (nearest rank) of a set of values.
ErrorSpread spread_of(std::vector<double> values);

}  // namespace hapton
