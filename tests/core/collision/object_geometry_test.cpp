#include "core/collision/object_geometry.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

// The same triangles as the mesh, in some order, within the grid's rounding.
TEST(ObjectGeometry, HoldsTheMeshesTriangles) {
  const TriangleMesh mesh = make_torus(0.04, 0.01, 24, 12);
  const LocalFrame frame{.origin = Vec3(0.01, 0, 0), .unit_m = 0.0625};
  const ObjectGeometry object(mesh, frame);
  ASSERT_EQ(object.triangle_count(), mesh.triangles.size());
  const auto less = [](const Vec3& a, const Vec3& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::vector<Vec3> expected;
  std::vector<Vec3> found;
  for (std::uint32_t t = 0; t < object.triangle_count(); ++t) {
    expected.push_back((mesh.corner(t, 0) + mesh.corner(t, 1) + mesh.corner(t, 2)) / 3.0);
    found.push_back(frame.to_scene((object.corner(t, 0) + object.corner(t, 1) + object.corner(t, 2)) / 3.0));
  }
  std::sort(expected.begin(), expected.end(), less);
  for (const Vec3& centroid : found) {
    const auto nearest = std::min_element(expected.begin(), expected.end(),
                                          [&](const Vec3& a, const Vec3& b) { return (a - centroid).norm() < (b - centroid).norm(); });
    EXPECT_LE((*nearest - centroid).norm(), 1e-15);
  }
}

TEST(ObjectGeometry, NeighboursAreNearInMemory) {
  const TriangleMesh mesh = make_icosphere(0.05, 5);
  const ObjectGeometry object(mesh, {});
  double way = 0.0;
  for (std::uint32_t t = 1; t < object.triangle_count(); ++t) way += (object.corner(t, 0) - object.corner(t - 1, 0)).norm();
  // Edges are about 2.3 mm long; an unordered list would jump by about 67 mm.
  EXPECT_LT(way / object.triangle_count(), 0.006);
}

TEST(ObjectGeometry, AnEmptyMeshIsEmpty) {
  const ObjectGeometry object(TriangleMesh(), {});
  EXPECT_EQ(object.triangle_count(), 0U);
  int visits = 0;
  object.tree().for_each_overlapping(Box{Vec3::Constant(-1), Vec3::Constant(1)}, [&](std::uint32_t) { ++visits; });
  EXPECT_EQ(visits, 0);
}

}  // namespace
}  // namespace hapton
