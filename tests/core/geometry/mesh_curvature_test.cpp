#include "core/geometry/mesh_curvature.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

double worst_relative_error(const TriangleMesh& mesh, double expected) {
  double worst = 0.0;
  for (const double curvature : compute_mean_curvature(mesh)) worst = std::max(worst, std::abs(curvature / expected - 1.0));
  return worst;
}

TriangleMesh inside_out(TriangleMesh mesh) {
  for (Triangle& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
  return mesh;
}

// With 16,000 triangles the curvature is within 1 %, and the error falls with the length of the edges.
TEST(MeshCurvature, OfASphereIsOneByItsRadius) {
  for (const double radius_m : {1e-4, 0.05, 300.0}) {
    const TriangleMesh coarse = made::sphere(radius_m, 16);
    const TriangleMesh fine = made::sphere(radius_m, 64);
    EXPECT_LT(worst_relative_error(fine, 1.0 / radius_m), 0.01) << radius_m;
    EXPECT_LT(worst_relative_error(fine, 1.0 / radius_m), 0.5 * worst_relative_error(coarse, 1.0 / radius_m)) << radius_m;
    EXPECT_LT(worst_relative_error(inside_out(fine), -1.0 / radius_m), 0.01) << "a hollow";
  }
}

// The relative error at the centre of a fan on a cylinder of radius 1 m. Angles and distance of other vertices: in the unrolled surface.
double error_on_cylinder(const std::vector<double>& angles_deg, double distance) {
  TriangleMesh fan;
  fan.vertices.emplace_back(1.0, 0.0, 0.0);
  const auto count = static_cast<std::uint32_t>(angles_deg.size());
  for (std::uint32_t i = 0; i < count; ++i) {
    const double angle_rad = angles_deg[i] * std::numbers::pi / 180.0;
    const double around_rad = distance * std::cos(angle_rad);
    fan.vertices.emplace_back(std::cos(around_rad), std::sin(around_rad), distance * std::sin(angle_rad));
    fan.triangles.push_back({0, 1 + i, 1 + (i + 1) % count});
  }
  return compute_mean_curvature(fan).front() / 0.5 - 1.0;
}

TEST(MeshCurvature, TheErrorFallsWithTheSquareOfTheEdgesAroundRegularTrianglesOnly) {
  const std::vector<double> regular = {0.0, 60.0, 120.0, 180.0, 240.0, 300.0};
  EXPECT_NEAR(error_on_cylinder(regular, 0.1) / error_on_cylinder(regular, 0.05), 4.0, 0.1);
  const std::vector<double> irregular = {0.0, 50.0, 120.0, 190.0, 230.0, 300.0};
  EXPECT_NEAR(error_on_cylinder(irregular, 0.1), 0.045, 0.001);
  EXPECT_NEAR(error_on_cylinder(irregular, 0.025), 0.045, 0.001);
  const std::vector<double> obtuse = {10.0, 100.0, 220.0};
  EXPECT_GT(error_on_cylinder(obtuse, 0.025), 2.0);
}

TEST(MeshCurvature, IsNotKnownAtAFlippedTriangle) {
  TriangleMesh mesh = made::sphere(1.0, 8);
  const Triangle flipped = mesh.triangles.front();
  std::swap(mesh.triangles.front()[1], mesh.triangles.front()[2]);
  const std::vector<double> curvature = compute_mean_curvature(mesh);
  for (const std::uint32_t vertex : flipped) EXPECT_TRUE(std::isnan(curvature[vertex])) << vertex;
  EXPECT_FALSE(std::isnan(curvature.back()));
}

TEST(MeshCurvature, OfAPlaneIsZeroAndOfItsBoundaryNotKnown) {
  TriangleMesh plane;
  constexpr std::uint32_t kSide = 6;
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) plane.vertices.emplace_back(0.01 * (i % kSide), 0.01 * (i / kSide), 0.2);
  for (std::uint32_t y = 0; y + 1 < kSide; ++y) {
    for (std::uint32_t x = 0; x + 1 < kSide; ++x) {
      const std::uint32_t a = y * kSide + x;
      plane.triangles.push_back({a, a + 1, a + kSide + 1});
      plane.triangles.push_back({a, a + kSide + 1, a + kSide});
    }
  }
  plane.vertices.emplace_back(9.0, 9.0, 9.0);  // a vertex of no triangle
  const std::vector<double> curvature = compute_mean_curvature(plane);
  for (std::uint32_t i = 0; i < kSide * kSide; ++i) {
    const bool is_inner = i % kSide > 0 && i % kSide + 1 < kSide && i / kSide > 0 && i / kSide + 1 < kSide;
    if (is_inner) {
      EXPECT_NEAR(curvature[i], 0.0, 1e-9) << i;
    }
    EXPECT_EQ(std::isnan(curvature[i]), !is_inner) << i;
  }
  EXPECT_TRUE(std::isnan(curvature.back()));
}

}  // namespace
}  // namespace hapton
