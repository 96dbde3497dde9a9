#include "bench/measure/facet_locator.h"

#include <limits>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_measures.h"

namespace hapton {

FacetLocator::FacetLocator(const TriangleMesh& mesh)
    : mesh_(mesh), origin_(compute_bounds(mesh).centre()), tree_(mesh.triangles.size(), [&](std::size_t i) {
        Box box;
        for (int k = 0; k < 3; ++k) box.grow(mesh.corner(i, k) - origin_);
        return box;
      }) {}

std::uint32_t FacetLocator::find_nearest(const Vec3& p) const {
  double least = std::numeric_limits<double>::infinity();
  std::uint32_t nearest = 0;
  tree_.visit_nearest(p - origin_, std::numeric_limits<double>::max(), [&](std::uint32_t triangle, double) {
    const double distance = closest_point(mesh_.corner(triangle, 0), mesh_.corner(triangle, 1), mesh_.corner(triangle, 2), p).distance;
    if (distance < least || (distance == least && triangle < nearest)) {
      least = distance;
      nearest = triangle;
    }
    return least * least * (1.0 + 1e-12);
  });
  return nearest;
}

std::uint64_t FacetLocator::count_crossed(const Vec3& from, const Vec3& to) const {
  if (from == to) return 0;
  std::uint64_t crossed = 0;
  std::uint32_t last = find_nearest(from);
  for (int i = 1; i <= kSamples; ++i) {
    const std::uint32_t now = find_nearest(i == kSamples ? to : Vec3(from + (static_cast<double>(i) / kSamples) * (to - from)));
    crossed += now != last ? 1 : 0;
    last = now;
  }
  return crossed;
}

}  // namespace hapton
