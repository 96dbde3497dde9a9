#include "core/geometry/vertex_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "core/geometry/closest_point.h"

namespace hapton {
namespace {

std::vector<Vec3> draw_points(std::uint64_t seed, std::size_t count, bool has_copies) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    points.emplace_back(symmetric(random), symmetric(random), symmetric(random));
    if (has_copies && i % 3 == 1) points.back() = points[i / 2];
  }
  return points;
}

std::vector<std::uint32_t> every_second(std::size_t count) {
  std::vector<std::uint32_t> items;
  for (std::uint32_t i = 0; i < count; i += 2) items.push_back(i);
  return items;
}

TEST(VertexTree, NearestAgreesWithBruteForce) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const std::vector<Vec3> points = draw_points(seed, 600, true);
    const std::vector<std::uint32_t> items = every_second(points.size());
    const VertexTree tree(points, items);
    std::vector<VertexTree::NearVertex> found;
    for (std::uint32_t q = 0; q < points.size(); ++q) {
      for (const auto& [radius, max_count] :
           {std::pair(0.2, std::size_t{1000}), std::pair(0.5, std::size_t{7}), std::pair(0.0, std::size_t{9})}) {
        std::vector<std::pair<double, std::uint32_t>> expected;
        for (const std::uint32_t i : items) {
          const double squared = (points[i] - points[q]).squaredNorm();
          if (i != q && squared <= radius * radius) expected.emplace_back(squared, i);
        }
        std::sort(expected.begin(), expected.end());
        expected.resize(std::min(expected.size(), max_count));
        tree.find_nearest(points[q], q, radius, max_count, found);
        ASSERT_EQ(found.size(), expected.size()) << "seed " << seed;
        for (std::size_t i = 0; i < expected.size(); ++i) {
          EXPECT_EQ(found[i].vertex, expected[i].second);
          EXPECT_EQ(found[i].squared_distance, expected[i].first);
        }
      }
    }
  }
}

TEST(VertexTree, NearASegmentAgreesWithBruteForce) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const std::vector<Vec3> points = draw_points(seed, 600, true);
    std::vector<Vec3> ends = draw_points(seed + 100, 80, false);
    for (std::size_t i = 0; i < 20; ++i) ends[i][static_cast<int>(i % 3)] = ends[i + 1][static_cast<int>(i % 3)];  // normal to an axis
    ends.push_back(ends.back());                                                                                   // of length zero
    const std::vector<std::uint32_t> items = every_second(points.size());
    VertexTree tree(points, items);
    std::vector<VertexTree::NearVertex> found;
    for (std::size_t e = 0; e + 1 < ends.size(); ++e) {
      std::vector<std::uint32_t> expected;
      for (const std::uint32_t i : items) {
        if (closest_point(ends[e], ends[e + 1], ends[e + 1], points[i]).distance <= 0.15) expected.push_back(i);
      }
      tree.find_near_segment(ends[e], ends[e + 1], 0.15, found);
      ASSERT_EQ(found.size(), expected.size()) << "seed " << seed << ", segment " << e;
      for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_EQ(found[i].vertex, expected[i]);
    }
  }
}

TEST(VertexTree, APointIsTestedAgainstALimitedNumberOfSegments) {
  const std::vector<Vec3> points(100, Vec3::Zero());
  std::vector<std::uint32_t> items(points.size());
  std::iota(items.begin(), items.end(), 0U);
  VertexTree tree(points, items);
  std::vector<VertexTree::NearVertex> found;
  std::size_t total_found = 0;
  for (std::uint32_t i = 0; i < 2 * VertexTree::kMaxSegments; ++i) {
    tree.find_near_segment(Vec3(-1.0, 0.0, 0.0), Vec3(1.0, 0.0, 0.0), 0.1, found);
    total_found += found.size();
  }
  EXPECT_EQ(total_found, points.size() * VertexTree::kMaxSegments);
}

TEST(VertexTree, OfNothingFindsNothing) {
  const std::vector<Vec3> points(3, Vec3::Zero());
  VertexTree tree(points, {});
  std::vector<VertexTree::NearVertex> found(1);
  tree.find_nearest(Vec3::Zero(), 0, 1.0, 5, found);
  EXPECT_TRUE(found.empty());
  tree.find_near_segment(Vec3::Zero(), Vec3::UnitX(), 1.0, found);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace hapton
