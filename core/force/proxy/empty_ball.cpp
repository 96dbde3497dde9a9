#include "core/force/proxy/empty_ball.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hapton {

// Finds no ball among too many triangles. Skips triangles that are hardly nearer than the nearest one so far: over a smooth surface there
// are thousands of them, and testing them would make the ball hardly larger.
double EmptyBall::find(const TouchGeometry& geometry, const Vec3& device, double displacement, double offset, double max_radius) noexcept {
  constexpr double kHardlyNearer = 0.75 * 0.75;  // a factor of squared distances
  const double widest = 64.0 * displacement + 4.0 * offset;
  double clear_squared = widest * widest;
  constexpr int kMaxTests = 256;  // about half of the work of a step (StepWork::kMax)
  work_ = 0;
  geometry.visit_nearest(device, clear_squared, [&](std::uint32_t triangle, double bound) {
    if (++work_ > kMaxTests) return clear_squared = 0.0;
    const double d = geometry.separation(triangle, device).distance;
    clear_squared = std::min(bound, kHardlyNearer * d * d);
    return clear_squared;
  });
  // Reduced by the rounding of the conversion to local units.
  const double radius = std::min(std::sqrt(clear_squared) * (1.0 - 0x1p-40) - offset, max_radius) - 0x1p-48 * (1.0 + device.norm());
  travel_until_search_ = std::max(0.25 * radius, 4.0 * displacement);
  return std::max(radius, 0.0);
}

void EmptyBall::enter(const TouchGeometry& geometry, const Vec3& p_SD, const Vec3& before_S, double radius) noexcept {
  const double radius_m = radius * geometry.unit_m();
  centre_S_ = p_SD;
  last_S_ = p_SD;
  before_S_ = before_S;
  radius_squared_m2_ = std::min(radius_m * radius_m, std::numeric_limits<double>::max());
}

void EmptyBall::leave(const TouchGeometry& geometry) noexcept {
  if (!exists()) return;
  radius_squared_m2_ = 0.0;
  travel_until_search_ -= (geometry.to_local(last_S_) - geometry.to_local(centre_S_)).norm();
}

}  // namespace hapton
