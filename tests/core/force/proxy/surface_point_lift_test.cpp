#include "core/force/proxy/surface_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"
#include "core/geometry/winding_number.h"

namespace hapton {
namespace {

double distance_to_mesh(const TriangleMesh& mesh, const Vec3& p) {
  double nearest = 1e300;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    nearest = std::min(nearest, closest_point(mesh.corner(i, 0), mesh.corner(i, 1), mesh.corner(i, 2), p).distance);
  }
  return nearest;
}

// A crumpled sphere: at many of its vertices no direction leads away from all faces. The lifted point must be on the same side of the
// surface as a point beside the vertex, just off one of the faces.
TEST(SurfacePoint, LiftedFromAnyVertexItIsOffTheSurfaceOnItsOwnSide) {
  constexpr double kHeight = 1e-10;
  int lifts = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    TriangleMesh mesh = make_icosphere(0.4, 2);
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal;
    for (Vec3& vertex : mesh.vertices) vertex += 0.06 * Vec3(normal(random), normal(random), normal(random));
    const TouchGeometry geometry({&mesh});
    const std::vector<Material> materials(1);
    const auto point = std::make_unique<SurfacePoint>(geometry, materials);
    for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) {
      for (int k = 0; k < 6; ++k) {
        const ObjectGeometry::Corners at = geometry.corners(i);
        const Vec3 middle = (at.a + at.b + at.c) / 3.0;
        if (!point->land(i, k < 3, middle) || !point->reach_vertex(k % 3)) continue;
        const Vec3 beside = point->point() + 1e-4 * (middle - point->point()) + 1e-10 * point->a().normal();
        const Vec3 p = geometry.to_scene(point->lifted(kHeight));
        ASSERT_NEAR(compute_winding_number(mesh, p), compute_winding_number(mesh, geometry.to_scene(beside)), 1e-3)
            << "seed " << seed << " triangle " << i << " corner " << k;
        ASSERT_GT(distance_to_mesh(mesh, p), 0.2 * kHeight) << "seed " << seed << " triangle " << i << " corner " << k;
        ++lifts;
      }
    }
  }
  EXPECT_GT(lifts, 1000);
}

}  // namespace
}  // namespace hapton
