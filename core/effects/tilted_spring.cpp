#include "core/effects/tilted_spring.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapton {

// K in the plane of n and the gradient g of the height: k (1, -g) (1, -g)' + diag(0, c), with c the sum of its terms along the surface.
double TiltedSpring::largest_n_per_m() const noexcept {
  const double along = bending_n_per_m + sideways_n_per_m;
  const double trace = spring_n_per_m * (1.0 + slope_squared) + along;
  const double determinant = spring_n_per_m * along;
  return 0.5 * (trace + std::sqrt(std::max(0.0, trace * trace - 4.0 * determinant)));
}

// Let a be the phases of the waves, and q the largest -cos(a). Then the curvature is at most q times its amplitude; the gradient of that
// wave is at most sqrt(1 - q^2) times its amplitude, those of the other waves (of a grid) at most their amplitudes. K grows with gradient
// and curvature, so in a range of q, the gradient at its lower end and the curvature at its upper end bound K.
double largest_on_bumps(const SurfaceBumps& bumps, double spring_n_per_m, double sideways_n_per_m, double pressed_n) noexcept {
  constexpr int kRanges = 64;  // more ranges give a tighter bound, and take longer
  const bool is_grid = bumps.pattern == SurfaceBumps::Pattern::grid;
  const double slope = bumps.slope() / (is_grid ? 3.0 : 1.0);  // slope of one wave
  const double curvature_per_m = slope * 2.0 * std::numbers::pi / bumps.length_m;
  double largest = 0.0;
  for (int i = 0; i < kRanges; ++i) {
    const double low = static_cast<double>(i) / kRanges;
    const double high = static_cast<double>(i + 1) / kRanges;
    const double gradients = (is_grid ? 3.0 : 1.0) - low * low;
    const TiltedSpring spring{.spring_n_per_m = spring_n_per_m,
                              .slope_squared = slope * slope * gradients,
                              .bending_n_per_m = pressed_n * curvature_per_m * high,
                              .sideways_n_per_m = sideways_n_per_m};
    largest = std::max(largest, spring.largest_n_per_m());
  }
  return largest;
}

}  // namespace hapton
