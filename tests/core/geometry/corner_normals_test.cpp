#include "core/geometry/corner_normals.h"

#include <gtest/gtest.h>

#include <numbers>
#include <numeric>
#include <set>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

ShadedMesh shade(const TriangleMesh& mesh, double crease_deg, CornerNormalReport& report) {
  std::vector<std::uint32_t> source(mesh.triangles.size());
  std::iota(source.begin(), source.end(), 0U);
  return fill_corner_normals(mesh, source, crease_deg * kDegree, report);
}

TEST(CornerNormals, OfASphereAreRadialAndShared) {
  const TriangleMesh mesh = make_icosphere(0.05, 3);
  CornerNormalReport report;
  const ShadedMesh shaded = shade(mesh, 40.0, report);
  EXPECT_EQ(report.sharp_edges, 0U);
  EXPECT_EQ(report.normals, mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((shaded.normal(t, k) - mesh.corner(t, k).normalized()).norm(), 0.01);
  }
}

TEST(CornerNormals, OfABoxAreItsFaces) {
  const TriangleMesh mesh = make_box(Vec3(1, 2, 3), 3);
  CornerNormalReport report;
  const ShadedMesh shaded = shade(mesh, 40.0, report);
  EXPECT_EQ(report.sharp_edges, 12U * 3U);
  EXPECT_EQ(report.creased, 8U + 12U * 2U);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3 face = (mesh.corner(t, 1) - mesh.corner(t, 0)).cross(mesh.corner(t, 2) - mesh.corner(t, 0)).normalized();
    for (int k = 0; k < 3; ++k) EXPECT_LT((shaded.normal(t, k) - face).norm(), 1e-12);
  }
  CornerNormalReport smooth;
  const ShadedMesh rounded = shade(mesh, 180.0, smooth);
  EXPECT_EQ(smooth.sharp_edges, 0U);
  EXPECT_EQ(smooth.normals, mesh.vertices.size());
}

// The angle, not the number of triangles, gives a face its weight.
TEST(CornerNormals, DoNotDependOnHowAFaceIsCut) {
  CornerNormalReport report;
  const ShadedMesh shaded = shade(make_box(Vec3(1, 1, 1)), 180.0, report);
  for (std::size_t t = 0; t < shaded.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((shaded.normal(t, k) - shaded.corner(t, k).normalized()).norm(), 1e-12);
  }
}

TEST(CornerNormals, FollowMovedVertices) {
  TriangleMesh mesh = make_icosphere(0.05, 2);
  CornerNormalReport report;
  ShadedMesh moved = shade(mesh, 40.0, report);
  for (Vec3& v : mesh.vertices) v = Vec3(v.x(), 1.3 * v.y(), v.z()) + Vec3(1, 2, 3);
  moved.vertices = mesh.vertices;
  update_corner_normals(moved, moved.triangles.size());
  const ShadedMesh anew = shade(mesh, 40.0, report);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) EXPECT_LT((moved.normal(t, k) - anew.normal(t, k)).norm(), 1e-12);
  }
}

TEST(CheckCornerNormals, RepairsWhatPointsAway) {
  const TriangleMesh mesh = make_icosphere(1.0, 1);
  CornerNormalReport report;
  ShadedMesh shaded = shade(mesh, 40.0, report);
  EXPECT_EQ(check_corner_normals(shaded).repaired(), 0U);
  shaded.normals[shaded.corner_normals[0][0]] *= -1.0;
  shaded.normals[shaded.corner_normals[0][1]] = Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0);
  const NormalCheckReport found = check_corner_normals(shaded);
  EXPECT_GT(found.turned_away, 4U);
  EXPECT_GT(found.not_unit, 4U);
  EXPECT_EQ(check_corner_normals(shaded).repaired(), 0U);
  for (std::size_t t = 0; t < shaded.triangles.size(); ++t) {
    const Vec3 face = (shaded.corner(t, 1) - shaded.corner(t, 0)).cross(shaded.corner(t, 2) - shaded.corner(t, 0)).normalized();
    for (int k = 0; k < 3; ++k) EXPECT_GT(shaded.normal(t, k).dot(face), 0.08);
  }
}

}  // namespace
}  // namespace hapton
