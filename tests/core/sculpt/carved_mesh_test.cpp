#include "core/sculpt/carved_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/geometry/mesh_measures.h"
#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

double volume_of(const TriangleMesh& mesh) {
  double volume = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    volume += mesh.corner(t, 0).dot(mesh.corner(t, 1).cross(mesh.corner(t, 2))) / 6.0;
  }
  return volume;
}

// The grid has several blocks along each axis, so that the surface crosses their borders.
TEST(CarvedMesh, HasNoOpenEdgeAndFacesOutwards) {
  const TriangleMesh ball = make_icosphere(0.03, 4);
  auto field = CarvedField::make(ball, 0.001);
  ASSERT_TRUE(field);
  const double whole_volume = volume_of(make_carved_mesh(*field));
  EXPECT_NEAR(whole_volume, volume_of(ball), 0.01 * volume_of(ball));
  const double radius = 0.008;
  field->carve({Vec3(-0.05, 0.004, 0.003), Vec3(0.05, 0.004, 0.003), radius});
  const TriangleMesh carved = make_carved_mesh(*field);
  const EdgeCensus edges = count_edges(carved);
  EXPECT_TRUE(edges.closed());
  // A cylinder whose axis passes the centre at 5 mm, the root of 4^2 + 3^2.
  const double bore_volume = std::numbers::pi * radius * radius * 2.0 * std::sqrt(0.03 * 0.03 - 25e-6);
  EXPECT_NEAR(whole_volume - volume_of(carved), bore_volume, 0.06 * bore_volume);
  for (const Vec3& vertex : carved.vertices) EXPECT_LT(std::abs(field->value(vertex)), 0.5 * field->spacing_m());
}

// Thin walls and rims between the carves, where several pieces of surface pass through one cell.
TEST(CarvedMesh, IsAManifoldAfterManyCarves) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(-0.03, 0.03);
  auto field = CarvedField::make(make_icosphere(0.03, 4), 0.001);
  ASSERT_TRUE(field);
  for (int n = 0; n < 120; ++n) {
    field->carve({Vec3(place(random), place(random), place(random)), Vec3(place(random), place(random), place(random)), 0.002});
    if (n % 20 != 19) continue;
    const EdgeCensus edges = count_edges(make_carved_mesh(*field));
    EXPECT_TRUE(edges.closed()) << n << ": " << edges.non_manifold << " edges of more than two triangles";
  }
}

TEST(CarvedMesh, OfNothingIsEmpty) {
  auto field = CarvedField::make(make_icosphere(0.01, 3), 0.001);
  ASSERT_TRUE(field);
  field->carve({Vec3::Zero(), Vec3::Zero(), 0.03});
  EXPECT_TRUE(make_carved_mesh(*field).triangles.empty());
}

}  // namespace
}  // namespace hapton
