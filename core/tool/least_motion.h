#pragma once

#include <array>
#include <span>

#include "core/tool/placement.h"

namespace hapton {

// The half-space row . y >= least, for a motion y of six coordinates.
struct MotionBound {
  Vec6 row = Vec6::Zero();
  double least = 0.0;
};

// The motion nearest to a goal that a set of bounds allows.
struct LeastMotion {
  Vec6 y = Vec6::Zero();
  std::array<int, 6> active = {-1, -1, -1, -1, -1, -1};  // indices of the active bounds
  Vec6 multipliers = Vec6::Zero();                       // y - goal = sum of multiplier * row over the active bounds; none is negative
  int active_count = 0;
  bool solved = true;  // false: no motion meets all bounds as far as rounding can tell, or the rounds ran out; y is then of no use
};

// Returns the y nearest to `goal` with row_i . y >= least_i - tolerance for all bounds. Where the coordinates are scaled by the square
// roots of a mass matrix, that is Gauss' principle of least constraint, and the multipliers are the contact forces (Ortega, Redon &
// Coquillart 2007, section 4). Algorithm: dual active set (Goldfarb & Idnani 1983) for a unit matrix. It begins at the goal and adds the
// bound that is violated most, so that the distance to the goal grows in every round. Each round reads every bound once. RT: yes. Pre:
// finite rows, none of them zero; tolerance > 0.
LeastMotion find_least_motion(const Vec6& goal, std::span<const MotionBound> bounds, double tolerance) noexcept;

}  // namespace hapton
