#pragma once

#include "core/effects/surface_maps.h"

namespace hapton {

// What an image of heights or of stiffness adds to the stiffness of a surface at most, wherever it is touched on its triangles: by branch
// and bound over the image, so that no place is left out and the result is at most kMapMargin times the largest for one
// mapping. Where triangles map the image unevenly, that of the steepest mapping counts everywhere. RT: no: up to 0.2 us a texel, most
// where the image is rough.
constexpr double kMapMargin = 1.05;

// The largest eigenvalue of the second derivative of the number along the surface, 1/m of a height; 0 or more.
double largest_curvature(const ImageMap& map, const std::vector<MappedTriangle>& triangles);

// A surface whose stiffness is a share of `spring_n_per_m` by an image, pressed with a force F. With s the share, the potential
// s U(p) of SurfaceMaps, p the depth, has the second derivative
//   K = s k v v' + s f grad grad h - f (v grad s' + grad s v') + U grad grad s,   s f <= F,   U <= F^2 / (2 k s^2).
// Pre: all shares are above 0.
struct MappedSpring {
  double spring_n_per_m = 0.0;    // k, above 0
  double beside_n_per_m = 0.0;    // of springs beside it, which the image does not scale
  double sideways_n_per_m = 0.0;  // of friction
  double pressed_n = 0.0;         // F

  // The largest of K without bumps.
  double largest_n_per_m(const ImageMap& share, const std::vector<MappedTriangle>& triangles) const;
  // What the last two terms add at most to bumps of this slope.
  double added_n_per_m(const ImageMap& share, const std::vector<MappedTriangle>& triangles, double slope) const;
};

}  // namespace hapton
