#pragma once

#include <array>
#include <span>

#include "core/math/types.h"

namespace hapton {

// The half-space normal . y >= height; normal has unit length. Undefined until it is set: a step has room for many planes and sets few.
struct ContactPlane {
  Vec3 normal;
  double height;
};

// How far a set of contact planes lets a motion go.
struct ConstrainedMotion {
  Vec3 motion = Vec3::Zero();
  std::array<int, 3> active = {-1, -1, -1};       // indices of the active planes
  std::array<double, 3> multipliers = {0, 0, 0};  // multipliers: motion - goal = sum of multiplier * normal over the active planes
  int active_count = 0;
  bool solved = true;  // false: up to rounding the planes allow no motion: `motion` is zero, the active planes mean nothing
};

// Returns the y nearest to `goal` with normal_i . y >= height_i for all planes: the god-object's constrained minimum (Zilles & Salisbury
// 1995). Exact for any number of planes: the optimum may have any set of up to three active planes.
// Algorithm: incremental, as for LP-type problems (Sharir & Welzl 1992). A violated plane must be active in the new optimum, so only its
// combinations with the planes active so far (at most seven) are tried. |y - goal| grows in every round, which bounds the loop. Any frame
// and unit. RT: yes. Pre: heights are small compared with |goal|, or the planes have a common feasible point near zero.
ConstrainedMotion constrain_motion(const Vec3& goal, std::span<const ContactPlane> planes) noexcept;

}  // namespace hapton
