#pragma once

#include <cstddef>
#include <vector>

#include "core/math/types.h"

namespace hapton {

// The delay of a signal, and the error that remains after removing the delay.
struct EffectiveOffset {
  double time_s = 0.0;  // mean
  double value = 0.0;   // mean, in the signals' unit
};

// Each sample i of `signal` is matched with sample i - d(i) of `reference`: 0 <= d <= max_delay, and d changes by one a sample at most, so
// that the matching keeps the order. The matching is the one with the least
//
//     sum |signal(i) - reference(i - d(i))|  +  step_cost * sum |d(i) - d(i-1)|
//
// found by dynamic programming. Where reference and signal do not determine d, it does not change. Means are over the samples at which
// either is above `min_norm`. d is never negative, because a force cannot precede the motion that causes it.
//
// After: Kroep, Gokhale, Verburg and Venkatesha Prasad, "ETVO: Effectively Measuring Tactile Internet with Experimental Validation"
// (arXiv 2107.05343), which refines dynamic time warping in the same sense. Band and step cost are ours, so the figures can only be
// compared with each other. Pre: both have the same length. Time and memory: samples times max_delay. RT: no.
EffectiveOffset find_effective_offset(const std::vector<Vec3>& signal, const std::vector<Vec3>& reference, double period_s,
                                      std::size_t max_delay, double step_cost, double min_norm);

}  // namespace hapton
