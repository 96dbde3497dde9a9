#include "core/force/mapped_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/geometry/mesh_shapes.h"
#include "tests/core/force/made_maps.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

MapSample brute_force(const SurfaceMaps& maps, const Vec3& p) {
  double nearest_m = std::numeric_limits<double>::infinity();
  MapSample sample;
  for (const MappedTriangle& triangle : *maps.triangles) {
    const ClosestPoint found = closest_point(triangle.corner[0], triangle.corner[1], triangle.corner[2], p);
    if (!(found.distance < nearest_m)) continue;
    nearest_m = found.distance;
    MapPlace place = map_gradients(triangle);
    const Vec3 off = found.point - triangle.corner[0];
    place.texcoord += Eigen::Vector2d(place.du.dot(off), place.dv.dot(off));
    sample = maps.sample(place);
  }
  return sample;
}

TEST(MapFinder, FindsThePlaceOfTheNearestPoint) {
  const TriangleMesh torus = make_torus(0.035, 0.015, 60, 24);
  const SurfaceMaps maps = made_maps(torus);
  MapFinder finder(maps);
  const std::uint64_t seed = 2;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int n = 0; n < 3000; ++n) {
    // Points on the surface, and points up to 2 mm off it along each axis, as the centre of a sphere is.
    const std::size_t t = random() % torus.triangles.size();
    const double a = unit(random);
    const double b = unit(random) * (1.0 - a);
    const Vec3 on = torus.corner(t, 0) + a * (torus.corner(t, 1) - torus.corner(t, 0)) + b * (torus.corner(t, 2) - torus.corner(t, 0));
    const Vec3 p = n % 2 == 0 ? on : Vec3(on + 0.002 * unit(random) * Vec3(unit(random), unit(random), unit(random)));
    EXPECT_NEAR(finder.find(p).height_m, brute_force(maps, p).height_m, 1e-8) << n;
  }
}

TEST(MapFinder, IsContinuousAlongAPathOverManyTriangles) {
  MapFinder finder(made_maps(make_torus(0.035, 0.015, 60, 24)));
  double before_m = finder.find({0.05, 0.0, 0.0}).height_m;
  for (int n = 1; n < 20000; ++n) {
    const double angle = 1e-3 * n;
    const double tube = 7e-4 * n;
    const double ring = 0.035 + 0.015 * std::cos(tube);
    const double now_m = finder.find({ring * std::cos(angle), ring * std::sin(angle), 0.015 * std::sin(tube)}).height_m;
    EXPECT_LT(std::abs(now_m - before_m), 2e-4) << n;
    before_m = now_m;
  }
}

TEST(MapFinder, UsesNoHeapAndTakesAnyPoint) {
  MapFinder finder(made_maps(make_torus(0.035, 0.015, 40, 16)));
  const AllocationGuard guard;
  for (int n = 0; n < 100; ++n) (void)finder.find(0.001 * n * Vec3(1, 0.3, 0.1));
  EXPECT_EQ(finder.find(Vec3::Constant(std::numeric_limits<double>::quiet_NaN())).height_m, 0.0);
  EXPECT_TRUE(std::isfinite(finder.find(Vec3::Constant(1e6)).height_m));
  EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U);
}

}  // namespace
}  // namespace hapton
