#include "core/geometry/triangle_sampler.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace hapton {
namespace {

// One unit triangle, one without an area, one twice as large.
TriangleMesh three_triangles() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {2, 0, 0}, {0, 2, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 3, 2}};
  return mesh;
}

TEST(TriangleSampler, DrawsByArea) {
  constexpr unsigned kSeed = 20261122;
  RecordProperty("seed", std::to_string(kSeed));
  const TriangleSampler draw(three_triangles());
  ASSERT_FALSE(draw.empty());
  std::mt19937_64 random(kSeed);
  std::array<int, 3> count = {};
  constexpr int kDraws = 30000;
  for (int i = 0; i < kDraws; ++i) ++count[draw(random)];
  EXPECT_EQ(count[1], 0);
  // Six standard deviations of a binomial distribution: sqrt(30000 * 1/3 * 2/3) is 82.
  EXPECT_NEAR(count[0], kDraws / 3, 6 * 82);
  EXPECT_NEAR(count[2], 2 * kDraws / 3, 6 * 82);
}

TEST(TriangleSampler, HasNothingToDrawWithoutAnArea) {
  EXPECT_TRUE(TriangleSampler(TriangleMesh{}).empty());
  TriangleMesh flat = three_triangles();
  flat.triangles = {{0, 1, 3}, {1, 1, 2}};
  EXPECT_TRUE(TriangleSampler(flat).empty());
}

}  // namespace
}  // namespace hapton
