#include "core/geometry/surface_walk.h"

#include <gtest/gtest.h>
#include <cmath>
#include <utility>

#include "core/geometry/closest_point.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TEST(SurfaceWalk, GoesStraightOverAFlatMesh) {
  const TriangleMesh mesh = make_plane_grid(1.0, 20);
  SurfaceWalk walk(mesh);
  walk.start(400, 0.3);
  const Vec3 from = walk.point();
  const Vec3 heading = walk.heading();
  for (int i = 0; i < 10; ++i) walk.advance(0.02);
  EXPECT_LT((walk.point() - (from + 0.2 * heading)).norm(), 1e-13);
  EXPECT_EQ(walk.normal(), Vec3(0, 0, 1));
}

TEST(SurfaceWalk, TurnsBackAtABoundary) {
  const TriangleMesh mesh = make_plane_grid(1.0, 4);
  SurfaceWalk walk(mesh);
  walk.start(9, 0.7);
  for (int i = 0; i < 1000; ++i) {
    walk.advance(0.05);
    ASSERT_LE(walk.point().cwiseAbs().maxCoeff(), 0.5 + 1e-12);
  }
}

TEST(SurfaceWalk, CirclesASphere) {
  const TriangleMesh mesh = make_icosphere(1.0, 4);
  SurfaceWalk walk(mesh);
  walk.start(100, 1.0);
  const Vec3 from = walk.point();
  double nearest = 1.0;
  for (int i = 0; i < 700; ++i) {
    walk.advance(0.01);
    ASSERT_LT(closest_point(mesh.corner(walk.triangle(), 0), mesh.corner(walk.triangle(), 1), mesh.corner(walk.triangle(), 2), walk.point())
                  .distance,
              1e-12);
    ASSERT_GT(walk.normal().dot(walk.point()), 0.9);
    ASSERT_NEAR(walk.heading().dot(walk.normal()), 0.0, 1e-12);
    if (i > 500) nearest = std::min(nearest, (walk.point() - from).norm());
  }
  EXPECT_LT(nearest, 0.3);  // the walk is a great circle, apart from the facets
}

TEST(SurfaceWalk, KeepsItsSideWhereWindingsDisagree) {
  TriangleMesh mesh = make_icosphere(1.0, 3);
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3) std::swap(mesh.triangles[i][0], mesh.triangles[i][1]);
  SurfaceWalk walk(mesh);
  walk.start(1, 1.0);
  for (int i = 0; i < 500; ++i) {
    walk.advance(0.02);
    ASSERT_GT(walk.normal().dot(walk.point()), 0.9);
  }
}

}  // namespace
}  // namespace hapton
