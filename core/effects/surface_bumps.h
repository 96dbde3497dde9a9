#pragma once

#include <cstdint>

#include "core/effects/effect_sample.h"

namespace hapton {

// Bumps by a formula, without triangles: the surface is lowered by a height map h(p) between -height_m and 0, p on the surface. With f(d)
// the force at penetration depth d, the force becomes f(d + h) (n - grad h), grad h along the surface, and zero where d + h is negative.
// That is the gradient of the potential of f at the depth d + h, so bumps push sideways just as much as climbing them costs.
//   ridges: h = -height / 2 (1 - cos(2 pi p . direction / length))
//   grid:   h = -height / 2 (1 - (cos(2 pi x / length) + cos(2 pi y / length) + cos(2 pi z / length)) / 3)
// Frame: S. Units: m. RT: yes.
//
// Bound: that of f times sqrt(1 + slope^2), slope = pi height / length. Passivity: conservative on flat surfaces without friction; on
// curved ones except for the change of the normal over the depth. Source: the lateral force of Minsky (1995) and the perturbed normal of
// Ho, Basdogan and Srinivasan (1999); that both come from one potential is ours.
struct SurfaceBumps {
  static constexpr Passivity kPassivity = Passivity::conservative;
  enum class Pattern : std::uint8_t { ridges, grid };

  Pattern pattern = Pattern::grid;
  double height_m = 0.0;           // from the lowest to the highest point; 0: off
  double length_m = 0.005;         // > 0: from one bump to the next
  Vec3 direction = Vec3::UnitX();  // unit, across the ridges

  bool is_on() const noexcept { return height_m > 0.0; }
  // The steepest slope of the bumps.
  double slope() const noexcept;
  double height_at(const Vec3& p_SP) const noexcept;
  Vec3 gradient_at(const Vec3& p_SP) const noexcept;
};

}  // namespace hapton
