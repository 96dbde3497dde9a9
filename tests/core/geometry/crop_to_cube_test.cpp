#include "core/geometry/crop_to_cube.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <vector>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

double area_of(const TriangleMesh& mesh) {
  double area = 0.0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    area += 0.5 * (mesh.corner(i, 1) - mesh.corner(i, 0)).cross(mesh.corner(i, 2) - mesh.corner(i, 0)).norm();
  }
  return area;
}

TriangleMesh crop_whole_mesh(const TriangleMesh& mesh, const Vec3& centre, double half_side) {
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0U);
  return crop_to_cube(mesh, all, centre, half_side);
}

TEST(CropToCube, ShowsWhatLiesInTheCubeAndNothingElse) {
  const TriangleMesh box = make_box(Vec3::Constant(1.0), 3);
  const TriangleMesh corner = crop_whole_mesh(box, Vec3(0.5, 0.4, 0.5), 0.25);  // three walls; 0.25 or 0.35 of their sides are in the cube
  EXPECT_NEAR(area_of(corner), 2.0 * 0.25 * 0.35 + 0.25 * 0.25, 1e-12);
  EXPECT_LE(compute_bounds(corner).high.maxCoeff(), 0.25);
  EXPECT_GE(compute_bounds(corner).low.minCoeff(), -0.25);
  EXPECT_NEAR(compute_bounds(corner).high.y(), 0.1, 1e-15);
  EXPECT_TRUE(crop_whole_mesh(box, Vec3::Zero(), 0.25).triangles.empty());
  EXPECT_NEAR(area_of(crop_whole_mesh(box, Vec3::Zero(), 0.75)), 6.0, 1e-12);
}

TEST(CropToCube, LeavesOutTrianglesThatOnlyTouchTheCube) {
  TriangleMesh mesh;
  mesh.vertices = {{0.25, 0.0, 0.0}, {0.25, 0.1, 0.0}, {1.0, 0.0, 0.0}, {1.0, 0.1, 0.1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};  // one touches with an edge, the other with a corner
  const TriangleMesh cropped = crop_whole_mesh(mesh, Vec3::Zero(), 0.25);
  EXPECT_TRUE(cropped.triangles.empty());
  EXPECT_TRUE(cropped.vertices.empty());
}

TEST(CropToCube, KeepsTheSideThatATriangleFaces) {
  const TriangleMesh whole = make_icosphere(0.5, 3);
  const TriangleMesh cropped = crop_whole_mesh(whole, Vec3(0.5, 0.0, 0.0), 0.2);
  ASSERT_GT(cropped.triangles.size(), 10U);
  for (std::size_t i = 0; i < cropped.triangles.size(); ++i) {
    EXPECT_GE((cropped.corner(i, 1) - cropped.corner(i, 0)).cross(cropped.corner(i, 2) - cropped.corner(i, 0)).x(), -1e-15);
  }
}

}  // namespace
}  // namespace hapton
