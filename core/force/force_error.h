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
// Relative error |F - F_ref| / |F_ref| and the angle between both, over the steps in which the reference is in contact. Steps of a basin
// change, where the reference itself moves by more than 1 % between its two sub-steppings (8 and 32 by custom), are counted apart: `away`
// leaves them out, `all` does not.
struct ForceError {
  std::size_t steps = 0;
  std::size_t contact_steps = 0;  // of the reference
  std::size_t basin_steps = 0;    // contact steps in which the reference depends on its sub-steps
  ErrorSpread all, away;          // share
  ErrorSpread direction_rad;      // away from basin changes
  std::size_t falls = 0;          // the method is free while the reference presses deeper than 0.25 % of the extent
  std::size_t ghosts = 0;         // the method presses by more than 0.25 % of the extent while the reference is free
  std::size_t locks =
      0;  // the method's proxy more than 10 % of the extent farther from the device than the reference's, while both references agree
  std::size_t pops = 0;  // |dF| above 2 k |dx| plus the reference's own |dF| there (the larger of both references, one step to either side)
  double worst_pop_n = 0.0;  // how far above
  std::size_t not_finite = 0;
  std::size_t worst_step = 0;  // of the largest relative error away from basin changes
};

// Compares a method step by step with the reference at its usual and at its finer sub-stepping, all over the same trajectory. Errors are
// against the finer one. Pre: equal lengths. RT: set-up only.
ForceError compare_forces(std::span<const FeltStep> method, std::span<const FeltStep> reference, std::span<const FeltStep> finer_reference,
                          const ForceErrorSettings& settings);

// RMS and quantiles (nearest rank) of a set of values.
ErrorSpread spread_of(std::vector<double> values);

}  // namespace hapton
