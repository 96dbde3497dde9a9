#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/math/types.h"

namespace hapton {

// The points v with normal . v >= gap. Pre: normal has unit length.
struct HalfSpace {
  Vec3 normal = Vec3::Zero();
  double gap = 0.0;
};

// The point of an intersection of half-spaces that is nearest to a goal.
struct HalfSpaceProjection {
  Vec3 point = Vec3::Zero();
  std::array<std::size_t, 3> active{};  // indices of the active half-spaces; the first `count` are valid
  std::array<double, 3> multiplier{};   // point = goal + sum multiplier_i normal_i; all >= -tolerance / 4
  int count = 0;
  bool feasible = false;  // false: no point was found that all half-spaces contain within the tolerance
};

// Projects `goal` onto the intersection. `tolerance`: how far a half-space may be violated, in the unit of goal. An LP-type problem of
// dimension 3: at most three planes determine the optimum. Each round adds the most violated half-space and keeps the subset that
// determines the projection onto these at most four: the distance grows strictly, up to rounding; the rounds are limited. In long
// double. RT: yes. Source: Sharir & Welzl, "A combinatorial bound for linear programming and related problems" (1992), the basis exchange.
HalfSpaceProjection project_onto_half_spaces(const Vec3& goal, std::span<const HalfSpace> half_spaces, double tolerance) noexcept;

}  // namespace hapton
