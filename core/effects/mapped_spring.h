#pragma once

#include "core/effects/surface_maps.h"

namespace hapton {

// The functions below find the most that an image of heights or of stiffness adds to the stiffness of a surface, wherever it is touched.
// They search the image by branch and bound, so that no place is left out; the result is at most kMapMargin times the largest value for one
// mapping. Where triangles map the image in different ways, the steepest mapping counts everywhere. RT: no: up to 0.2 us a texel, most
// where the image is rough.
constexpr double kMapMargin = 1.05;

// The largest eigenvalue of the second derivative, along the surface, of the map's number (for a height in 1/m); 0 or more.
double largest_curvature(const ImageMap& map, const std::vector<MappedTriangle>& triangles);

// A surface whose stiffness is `spring_n_per_m` times a share s that an image gives, pressed with a force F. At the depth p, the potential
// s U(p) of SurfaceMaps has the second derivative (v as in TiltedSpring)
//   K = s k v v' + s f grad grad h - f (v grad s' + grad s v') + U grad grad s,   s f <= F,   U <= F^2 / (2 k s^2).
// Pre: all shares are above 0.
struct MappedSpring {
  double spring_n_per_m = 0.0;    // k, above 0
  double beside_n_per_m = 0.0;    // springs beside k that the image does not scale
  double sideways_n_per_m = 0.0;  // spring of friction along the surface
  double pressed_n = 0.0;         // F

  // The largest eigenvalue of K without bumps.
  double largest_n_per_m(const ImageMap& share_map, const std::vector<MappedTriangle>& triangles) const;
  // The most that the last two terms of K add on bumps of this slope.
  double added_n_per_m(const ImageMap& share_map, const std::vector<MappedTriangle>& triangles, double slope) const;
};

}  // namespace hapton
