#include "core/force/reference/triangle_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

// The distance of p from the box of a triangle.
double distance_to_box(const std::vector<Vec3>& vertices, const Triangle& triangle, const Vec3& p) {
  const Vec3 &a = vertices[triangle[0]], &b = vertices[triangle[1]], &c = vertices[triangle[2]];
  const Vec3 beside = (a.cwiseMin(b).cwiseMin(c) - p).cwiseMax(p - a.cwiseMax(b).cwiseMax(c));
  return beside.cwiseMax(0.0).norm();
}

class BoxesOfRandomTriangles : public testing::TestWithParam<std::uint64_t> {};

TEST_P(BoxesOfRandomTriangles, AreFoundAsOneByOneInDoublePrecision) {
  RecordProperty("seed", std::to_string(GetParam()));
  std::mt19937_64 random(GetParam());
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const auto point = [&] { return Vec3(number(random), number(random), number(random)); };
  for (const double scale : {1e-7, 1.0, 1e12}) {
    std::vector<Vec3> vertices(300);
    std::vector<Triangle> triangles;
    for (Vec3& vertex : vertices) vertex = scale * (Vec3(2.0, -1.0, 0.0) + point());
    for (std::uint32_t i = 0; i < 300; i += 3) triangles.push_back({i, i + 1, i + 2});
    TriangleBoxes boxes(vertices, triangles);
    int near_count = 0;
    int far_count = 0;
    for (int i = 0; i < 400; ++i) {
      const Vec3 p = scale * (Vec3(2.0, -1.0, 0.0) + 3.0 * point());
      const double bound = i % 4 == 0 ? distance_to_box(vertices, triangles[i % 100], p) : scale * std::abs(number(random));
      const auto near = boxes.find_near(p, bound);
      ASSERT_TRUE(std::is_sorted(near.begin(), near.end()));
      for (std::uint32_t t = 0; t < triangles.size(); ++t) {
        const double distance = distance_to_box(vertices, triangles[t], p);
        const bool is_near = std::binary_search(near.begin(), near.end(), t);
        EXPECT_TRUE(is_near || distance > bound) << "triangle " << t << ", scale " << scale;
        EXPECT_TRUE(!is_near || distance <= bound + 3e-5 * scale) << "triangle " << t << ", scale " << scale;
        ++(is_near ? near_count : far_count);
      }
    }
    EXPECT_GT(near_count, 1000);
    EXPECT_GT(far_count, 1000);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, BoxesOfRandomTriangles, testing::Values(1, 2, 3));

TEST(TriangleBoxesTest, AVeryLargeBoundFindsAll) {
  const std::vector<Vec3> vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  TriangleBoxes boxes(vertices, triangles);
  EXPECT_EQ(boxes.find_near(Vec3::Constant(1e300), 1e301).size(), 1U);
  EXPECT_TRUE(boxes.find_near(Vec3::Constant(5.0), 0.0).empty());
}

TEST(TriangleBoxesTest, SearchesWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted here";
  const std::vector<Vec3> vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangles = {{0, 1, 2}};
  TriangleBoxes boxes(vertices, triangles);
  AllocationGuard guard;
  (void)boxes.find_near(Vec3::Zero(), 1.0);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
