#pragma once

#include <random>

#include "core/math/types.h"

namespace hapton {

// A vector whose coordinates are uniform in -1..1, drawn in the order x, y, z.
inline Vec3 draw_in_cube(std::mt19937_64& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const double x = uniform(random);
  const double y = uniform(random);
  return {x, y, uniform(random)};
}

}  // namespace hapton
