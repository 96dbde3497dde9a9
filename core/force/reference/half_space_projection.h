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

// The nearest point of an intersection of half-spaces.
struct HalfSpaceProjection {
  Vec3 point = Vec3::Zero();
  std::array<std::size_t, 3> active{};  // the half-spaces whose planes hold the point; the first `count`
  std::array<double, 3> multiplier{};   // point = goal + sum multiplier_i normal_i, all >= 0
  int count = 0;
  bool feasible = false;  // false: the half-spaces have no point in common within the tolerance
};

// Projects `goal` onto the intersection. `tolerance`: how far a half-space may be violated, in the unit of goal.
// An LP-type problem of dimension 3: the optimum is held by at most three planes; each round the most violated half-space enters and the
// best subset of the at most four is kept, so the distance grows strictly and the rounds end. Extended precision inside.
// RT: yes. Source: Sharir & Welzl, "A combinatorial bound for linear programming and related problems" (1992), the basis exchange.
HalfSpaceProjection project_onto_half_spaces(const Vec3& goal, std::span<const HalfSpace> half_spaces, double tolerance) noexcept;

}  // namespace hapton
