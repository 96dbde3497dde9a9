#include "core/collision/near_triangles.h"

namespace hapton {

bool NearTriangles::gather(const TouchGeometry& geometry, const Vec3& centre, double within, int& looked_at) noexcept {
  // Nearer, and the direction to a triangle has too few digits to bound anything by.
  constexpr double kLeastDistance = 0x1p-30;
  geometry_ = &geometry;
  centre_ = centre;
  within_ = within;
  count_ = 0;
  bool fits = true;
  const double within_squared = within * within;
  geometry.visit_nearest(centre, within_squared, [&](std::uint32_t triangle, double bound) {
    ++looked_at;
    const Separation at = geometry.separation(triangle, centre);
    if (at.distance > within) return bound;
    if (count_ == kCapacity) {
      fits = false;
      return 0.0;
    }
    const bool is_sure = at.distance > kLeastDistance;
    // The normal may lean by normal_error: within the ball gathered that takes off at most as much.
    distance_[count_] = is_sure ? at.distance - normal_error(at) * within : -std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) normal_[k][count_] = is_sure ? at.normal[k] : 0.0;
    triangle_[count_] = triangle;
    is_prepared_[count_] = false;
    ++count_;
    return bound;
  });
  if (!fits) {
    clear();
    return false;
  }
  for (int i = count_; i % 4 != 0; ++i) {
    distance_[i] = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) normal_[k][i] = 0.0;
  }
  return true;
}

}  // namespace hapton
