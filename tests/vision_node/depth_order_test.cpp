#include "vision_node/depth_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

namespace hapton {
namespace {

TEST(DepthOrder, PutsTheFarthestTriangleFirst) {
  constexpr unsigned kSeed = 4711;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<float> coordinate(-1.0F, 1.0F);
  std::vector<FlatVertex> vertices(300);
  for (FlatVertex& vertex : vertices) vertex.position = Vec3f(coordinate(random), coordinate(random), coordinate(random));
  std::vector<std::uint32_t> indices;
  for (int i = 0; i < 900; ++i) indices.push_back(static_cast<std::uint32_t>(random() % 300));
  const std::vector<std::uint32_t> before = indices;
  const Vec3f p_UE(0.3F, -2.0F, 1.5F);
  sort_far_to_near(indices, vertices, p_UE);
  const auto squared_distance = [&](std::size_t i) {
    return ((vertices[indices[i]].position + vertices[indices[i + 1]].position + vertices[indices[i + 2]].position) / 3.0F - p_UE)
        .squaredNorm();
  };
  for (std::size_t i = 3; i < indices.size(); i += 3) ASSERT_GE(squared_distance(i - 3), squared_distance(i)) << i;
  const auto triangles_of = [](const std::vector<std::uint32_t>& all) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::size_t i = 0; i < all.size(); i += 3) triangles.push_back({all[i], all[i + 1], all[i + 2]});
    std::sort(triangles.begin(), triangles.end());
    return triangles;
  };
  EXPECT_EQ(triangles_of(indices), triangles_of(before)) << "no triangle is lost or rotated";
}

TEST(DepthOrder, KeepsTheOrderOfWhatIsEquallyFar) {
  const std::vector<FlatVertex> vertices = {{Vec3f(0, 0, 0), 0}, {Vec3f(1, 0, 0), 0}, {Vec3f(0, 1, 0), 0}};
  std::vector<std::uint32_t> indices = {0, 1, 2, 1, 2, 0, 2, 0, 1};
  const std::vector<std::uint32_t> before = indices;
  sort_far_to_near(indices, vertices, Vec3f(0, 0, 5));
  EXPECT_EQ(indices, before);
}

TEST(DepthOrder, OrdersClusters) {
  std::vector<DetailCluster> clusters(3);
  clusters[0].centre = Vec3f(0, 0, 0.5F);
  clusters[1].centre = Vec3f(0, 0, -1);
  clusters[2].centre = Vec3f(0, 0, 0.5F);
  EXPECT_EQ(order_far_to_near(clusters, Vec3f(0, 0, 4)), (std::vector<std::uint32_t>{1, 0, 2}));
  EXPECT_EQ(order_far_to_near(clusters, Vec3f(0, 0, -4)), (std::vector<std::uint32_t>{0, 2, 1}));
}

}  // namespace
}  // namespace hapton
