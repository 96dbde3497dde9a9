#include "bench/measure/facet_locator.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(FacetLocator, FindsTheNearestOfAll) {
  const TriangleMesh mesh = make_bumpy_sphere(0.05, 0.3, 1000, 3);
  const FacetLocator locator(mesh);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> coordinate(-0.06, 0.06);
  for (int i = 0; i < 200; ++i) {
    const double x = coordinate(random), y = coordinate(random), z = coordinate(random);
    const Vec3 p(x, y, z);
    double least_distance = 1.0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      least_distance = std::min(least_distance, closest_point(mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), p).distance);
    const std::uint32_t nearest_triangle = locator.find_nearest(p);
    EXPECT_EQ(
        closest_point(mesh.corner(nearest_triangle, 0), mesh.corner(nearest_triangle, 1), mesh.corner(nearest_triangle, 2), p).distance,
        least_distance);
  }
}

// The path crosses a row of ten squares of two triangles each: ten diagonals, and nine sides between two squares.
TEST(FacetLocator, CountsFacetsOnThePath) {
  const TriangleMesh mesh = make_plane_grid(0.1, 10);
  const FacetLocator locator(mesh);
  std::uint64_t crossed = 0;
  constexpr int kSteps = 40;
  const auto point_at = [](int i) { return Vec3(-0.0499 + 0.0998 * i / kSteps, 0.0023, 0.0); };
  for (int i = 0; i < kSteps; ++i) crossed += locator.count_crossed(point_at(i), point_at(i + 1));
  EXPECT_EQ(crossed, 19u);
  EXPECT_EQ(locator.count_crossed(point_at(3), point_at(3)), 0u);
}

}  // namespace
}  // namespace hapton
