#include "scene/surface_points.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TEST(SurfacePoints, AreSpreadOverTheSurface) {
  const TouchScene scene{.objects = {{made::shared(make_icosphere(1.0, 4)), {}}}};
  const std::vector<Vec3> points = find_surface_points(scene, 16);
  ASSERT_EQ(points.size(), 16U);
  double least_distance = 10.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(points[i].norm(), 1.0, 0.02);
    for (std::size_t j = 0; j < i; ++j) least_distance = std::min(least_distance, (points[i] - points[j]).norm());
  }
  EXPECT_GT(least_distance, 0.4);
  EXPECT_EQ(points, find_surface_points(scene, 16));
}

TEST(SurfacePoints, LieOnEveryObject) {
  TriangleMesh aside = make_icosphere(1.0, 3);
  for (Vec3& v : aside.vertices) v += Vec3(10, 0, 0);
  const TouchScene scene{.objects = {{made::shared(make_icosphere(1.0, 3)), {}}, {made::shared(aside), {}}}};
  std::size_t on_first = 0;
  const std::vector<Vec3> points = find_surface_points(scene, 16);
  for (const Vec3& p : points) on_first += p.x() < 5.0 ? 1 : 0;
  EXPECT_GT(on_first, 4U);
  EXPECT_LT(on_first, 12U);
}

// A hand that comes from the front misses a face that is parallel to its path.
TEST(SurfacePoints, LieOnFacesThatAreSeenFromTheFront) {
  const TouchScene box{.objects = {{made::shared(make_box(Vec3(1, 2, 3))), {}}}};
  const std::vector<Vec3> points = find_surface_points(box, 16);
  EXPECT_EQ(points.size(), 4U);
  for (const Vec3& p : points) EXPECT_NEAR(std::abs(p.z()), 1.5, 1e-9);
}

TEST(SurfacePoints, LieOnASheetThatIsSeenEdgeOn) {
  TriangleMesh sheet;
  sheet.vertices = {Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)};
  sheet.triangles = {{0, 1, 2}};
  EXPECT_EQ(find_surface_points({.objects = {{made::shared(sheet), {}}}}, 16).size(), 1U);
}

TEST(SurfacePoints, AreNoMoreThanThereAreTriangles) {
  TriangleMesh one;
  one.vertices = {Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)};
  one.triangles = {{0, 1, 2}};
  EXPECT_EQ(find_surface_points({.objects = {{made::shared(one), {}}}}, 16).size(), 1U);
  EXPECT_TRUE(find_surface_points({}, 16).empty());
}

}  // namespace
}  // namespace hapton
