#include "core/geometry/mesh_deformation.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

MeshDeformation two_targets(bool loops) {
  return {{{{1, 3}, {Vec3(1, 0, 0), Vec3(0, 2, 0)}}, {{0, 1}, {Vec3(0, 0, 1), Vec3(0, 0, -4)}}},
          {{0.5, {0.0, 1.0}}, {1.5, {1.0, 0.0}}, {2.5, {0.0, 1.0}}},
          loops};
}

TEST(MeshDeformation, IsTheSumOfItsTargetsByTheirWeights) {
  const MeshDeformation deformation = two_targets(false);
  ASSERT_EQ(std::vector<std::uint32_t>(deformation.moved().begin(), deformation.moved().end()), (std::vector<std::uint32_t>{0, 1, 3}));
  const auto weights = deformation.weights_at(0.75);
  EXPECT_DOUBLE_EQ(weights[0], 0.25);
  EXPECT_DOUBLE_EQ(weights[1], 0.75);
  const std::vector<Vec3> rest(4, Vec3(5, 5, 5));
  const auto deformed = deformation.vertices_at(rest, weights);
  EXPECT_EQ(deformed[0], Vec3(5, 5, 5.75));
  EXPECT_EQ(deformed[1], Vec3(5.25, 5, 2));
  EXPECT_EQ(deformed[2], rest[2]);
  EXPECT_EQ(deformed[3], Vec3(5, 5.5, 5));
}

TEST(MeshDeformation, KeepsItsFirstAndLastWeightsOrLoops) {
  const MeshDeformation once = two_targets(false);
  EXPECT_EQ(once.weights_at(-1.0), once.weights_at(0.5));
  EXPECT_EQ(once.weights_at(99.0), once.weights_at(2.5));
  const MeshDeformation looping = two_targets(true);
  for (const double time : {0.0, 0.6, 1.7, 2.4}) EXPECT_NEAR(looping.weights_at(time + 5.0)[0], looping.weights_at(time)[0], 1e-12) << time;
  EXPECT_NEAR(looping.time_in_loop(7.6), 0.1, 1e-12);
}

// By brute force, no vertex moves farther than the bound; the speed of the fastest vertex is the one computed by hand.
TEST(MeshDeformation, BoundsDisplacementAndSpeed) {
  const MeshDeformation deformation = two_targets(false);
  const std::vector<Vec3> rest(4, Vec3::Zero());
  std::mt19937_64 random(4);
  SCOPED_TRACE("seed 4");
  std::uniform_real_distribution<double> time(0.0, 3.0);
  for (int i = 0; i < 200; ++i) {
    const auto a = deformation.weights_at(time(random));
    const auto b = deformation.weights_at(time(random));
    const auto from = deformation.vertices_at(rest, a);
    const auto to = deformation.vertices_at(rest, b);
    for (std::size_t v = 0; v < 4; ++v) EXPECT_LE((to[v] - from[v]).norm(), deformation.most_displacement(a, b) + 1e-12);
  }
  // Vertex 1 moves from (0, 0, -4) to (1, 0, 0) in one second.
  EXPECT_DOUBLE_EQ(deformation.fastest_per_s(0), std::sqrt(17.0));
}

TEST(MeshDeformation, ComparesAllNumbers) {
  EXPECT_TRUE(two_targets(true) == two_targets(true));
  EXPECT_FALSE(two_targets(true) == two_targets(false));
  auto targets = two_targets(true).targets();
  targets[1].displacements[0].x() += 1e-9;
  EXPECT_FALSE(two_targets(true) == MeshDeformation(targets, two_targets(true).keys(), true));
}

}  // namespace
}  // namespace hapton
