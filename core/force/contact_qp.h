#pragma once

#include <array>
#include <span>

#include "core/math/types.h"

namespace hapton {

// The half-space normal . y >= height; normal is unit.
struct ContactPlane {
  Vec3 normal = Vec3::Zero();
  double height = 0.0;
};

// Where a set of contact planes lets a motion end.
struct ConstrainedMotion {
  Vec3 motion = Vec3::Zero();
  std::array<int, 3> active = {-1, -1, -1};  // planes that push
  std::array<double, 3> push = {0, 0, 0};    // how much each: motion - goal = sum of push * normal
  int active_count = 0;
  bool solved = true;  // false: the planes leave no way that rounding can tell from standing still
};

// The y nearest to `goal` with normal_i . y >= height_i for all planes: the god-object's constrained minimum
// (Zilles & Salisbury 1995), solved exactly over every active set of up to three planes and any number of planes.
// Incremental as a linear-program-type problem (Sharir & Welzl 1992): a violated plane must be active in the new optimum,
// so only its seven sets with the three planes that were active are tried; |y - goal| grows each time, which bounds the loop.
// RT: yes. Pre: heights are small against |goal| or the planes have a common feasible point near zero.
ConstrainedMotion constrain_motion(const Vec3& goal, std::span<const ContactPlane> planes) noexcept;

}  // namespace hapton
