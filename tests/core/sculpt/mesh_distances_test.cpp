#include "core/sculpt/mesh_distances.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "core/geometry/point_in_mesh.h"
#include "core/geometry/winding_number.h"

namespace hapton {
namespace {

constexpr double kRounding = 1e-6;  // rounding of a float, relative to the band

FieldGrid grid_around(double half_m, double spacing_m) {
  const int nodes = static_cast<int>(std::ceil(2.0 * half_m / spacing_m / 8.0)) * 8;
  return {.origin_m = Vec3::Constant(-0.5 * spacing_m * (nodes - 1)), .spacing_m = spacing_m, .nodes = {nodes, nodes, nodes}};
}

std::vector<float> compute_values(const TriangleMesh& mesh, const FieldGrid& grid, double band_m) {
  std::vector<float> values(grid.size());
  compute_mesh_distances(mesh, grid, band_m, values);
  return values;
}

template <class Visit>
void for_each_node(const FieldGrid& grid, Visit&& visit) {
  for (int z = 0; z < grid.nodes[2]; ++z) {
    for (int y = 0; y < grid.nodes[1]; ++y) {
      for (int x = 0; x < grid.nodes[0]; ++x) visit(grid.node(x, y, z), grid.index(x, y, z));
    }
  }
}

// Checks the distance at each node against all triangles, and its sign against the solid angle of the mesh.
void expect_as_brute_force(const TriangleMesh& mesh, const FieldGrid& grid, double band_m) {
  const std::vector<float> values = compute_values(mesh, grid, band_m);
  const PointInMesh twin(mesh);
  for_each_node(grid, [&](const Vec3& p, std::size_t i) {
    const double distance = std::min(band_m, twin.compute_distance(p));
    const bool is_inside = std::abs(compute_winding_number(mesh, p)) > 0.5;
    ASSERT_NEAR(values[i], is_inside ? -distance : distance, kRounding * band_m) << p.transpose();
  });
}

TEST(MeshDistances, AreThoseByBruteForce) {
  expect_as_brute_force(make_bumpy_sphere(0.05, 0.2, 300, 7), grid_around(0.07, 0.011), 0.03);
  expect_as_brute_force(make_torus(0.04, 0.013, 17, 9), grid_around(0.07, 0.013), 0.025);
  expect_as_brute_force(joined(make_icosphere(0.03, 1), scaled_and_moved(make_icosphere(0.03, 1), 1.0, Vec3(0.02, 0.005, 0.0))),
                        grid_around(0.06, 0.012), 0.03);
}

// The grid covers only a part of the mesh: no value beyond the grid is written, and all its nodes have the right values.
TEST(MeshDistances, OfAMeshThatGoesBeyondTheGridAreThoseOfItsNodes) {
  const TriangleMesh ball = make_icosphere(0.05, 2);
  for (const double x : {-0.06, -0.02, 0.02}) {
    for (const double yz : {-0.055, -0.01, 0.025}) {
      expect_as_brute_force(ball, {.origin_m = {x, yz, yz}, .spacing_m = 0.0051, .nodes = {8, 7, 6}}, 0.012);
    }
  }
}

// Rows of nodes lie in faces, in edges and through vertices.
TEST(MeshDistances, OfABoxWhoseFacesLieInTheGridAreExact) {
  const FieldGrid grid{.origin_m = Vec3::Constant(-0.08), .spacing_m = 0.01, .nodes = {20, 17, 17}};
  for (const int cells : {1, 5}) {
    const std::vector<float> values = compute_values(make_box(Vec3::Constant(0.1), cells), grid, 0.03);
    for_each_node(grid, [&](const Vec3& p, std::size_t i) {
      const Vec3 beyond_face = p.cwiseAbs().array() - 0.05;
      const double exact_distance = beyond_face.cwiseMax(0.0).norm() + std::min(0.0, beyond_face.maxCoeff());
      // On the surface itself the sign may be either.
      if (std::abs(exact_distance) < 1e-9) {
        ASSERT_NEAR(values[i], 0.0, 1e-8);
      } else {
        ASSERT_NEAR(values[i], std::clamp(exact_distance, -0.03, 0.03), 3e-8) << p.transpose();
      }
    });
  }
}

TEST(MeshDistances, OfAMeshThatIsInsideOutAreTheSame) {
  const FieldGrid grid = grid_around(0.06, 0.01);
  const TriangleMesh sphere = make_icosphere(0.04, 2);
  EXPECT_EQ(compute_values(sphere, grid, 0.02), compute_values(flipped(sphere), grid, 0.02));
}

}  // namespace
}  // namespace hapton
