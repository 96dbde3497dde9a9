#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// What one method felt in one step. Frame W or S, SI.
struct FeltStep {
  Vec3 device = Vec3::Zero();
  Vec3 proxy = Vec3::Zero();
  Vec3 force_n = Vec3::Zero();
  bool settled = true;  // the reference: false where ever finer sub-steps still changed its force
};

struct ForceErrorSettings {
  double stiffness_n_per_m = 1000.0;
  double extent_m = 0.1;        // the longest side of what is touched: falls and locks follow it
  std::size_t reset_every = 0;  // no jump is counted across a reset
};

// Quantiles of one quantity. All zero when nothing was counted.
struct ErrorSpread {
  std::size_t count = 0;
  double rms = 0.0, p50 = 0.0, p99 = 0.0, most = 0.0;
};

// How a method stands to the reference.
//
// Relative error |F - F_ref| / |F_ref| and the angle between both, over every step in which the reference is in contact. None is left out.
// A branch switch is an episode of consecutive contact steps in which the method stays more than kBranchShare of the force away from the
// reference: it is in another local minimum. All steps of the episode count as errors, as long as it lasts; nothing brings the two together
// again but the surface itself, a reset, or a new window of whoever drives them. Episodes and their steps are counted in addition.
struct ForceError {
  static constexpr double kBranchShare = 0.01;

  std::size_t steps = 0;
  std::size_t contact_steps = 0;    // of the reference
  std::size_t unsettled_steps = 0;  // contact steps in which the reference has not settled; they count as all others
  ErrorSpread error;                // share
  ErrorSpread direction_rad;
  std::size_t branch_switches = 0;  // episodes
  std::size_t switched_steps = 0;   // in all of them
  std::size_t falls = 0;            // the method is free while the reference presses deeper than 0.25 % of the extent
  std::size_t ghosts = 0;           // the method presses by more than 0.25 % of the extent while the reference is free
  std::size_t locks = 0;            // the method's proxy more than 10 % of the extent farther from the device than the reference's
  std::size_t pops = 0;             // |dF| above 2 k |dx| plus the reference's own largest |dF| there, one step to either side
  double worst_pop_n = 0.0;         // how far above
  std::size_t not_finite = 0;
  std::size_t worst_step = 0;  // of the largest relative error
};

// Compares a method step by step with the reference over the same trajectory. Pre: equal lengths. RT: set-up only.
ForceError compare_forces(std::span<const FeltStep> method, std::span<const FeltStep> reference, const ForceErrorSettings& settings);

// RMS and quantiles (nearest rank) of a set of values.
ErrorSpread spread_of(std::vector<double> values);

}  // namespace hapton
