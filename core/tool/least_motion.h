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
  bool solved = true;  // false: within rounding no motion meets all bounds, or the limit of rounds was reached; y is then not usable
};

// Returns the y nearest to `goal` with row_i . y >= least_i - tolerance for all bounds. If the coordinates are scaled by the square root of
// a mass matrix, this is Gauss' principle of least constraint, and the multipliers are the contact forces (Ortega, Redon & Coquillart 2007,
// section 4). Algorithm: dual active set (Goldfarb & Idnani 1983) with the identity as Hessian. It starts at the goal and always adds the
// bound that is violated most; the distance to the goal never shrinks. At most 200 rounds, of at most one pass over the bounds, and one
// pass more. RT: yes. Pre: finite rows, none of them zero; tolerance > 0.
LeastMotion find_least_motion(const Vec6& goal, std::span<const MotionBound> bounds, double tolerance) noexcept;

}  // namespace hapton
