#include "core/geometry/median_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <vector>

namespace hapton {
namespace {

using MedianNode = MedianTree::Node;

constexpr std::uint32_t kLeafSize = 4;

std::vector<Vec3> scattered_points(std::uint64_t seed, std::size_t count, bool has_copies) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> symmetric(-1.0, 1.0);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i) {
    points.emplace_back(symmetric(random), symmetric(random), symmetric(random));
    if (has_copies && i % 2 == 1) points.back() = points[i / 4];
  }
  return points;
}

MedianTree tree_over(std::vector<Vec3>& points) { return {points, kLeafSize, std::identity{}, std::identity{}}; }

double squared_distance(const MedianNode& node, const Vec3& to) { return node.box.squaredExteriorDistance(to); }

TEST(MedianTree, HalvesTheItemsOfEachNodeAlongTheLongestSide) {
  for (const std::uint64_t seed : {1U, 2U}) {
    for (const std::size_t count : {1U, 4U, 5U, 8U, 1000U}) {
      for (const bool has_copies : {false, true}) {
        std::vector<Vec3> points = scattered_points(seed, count, has_copies);
        const MedianTree tree = tree_over(points);
        ASSERT_EQ(tree.nodes().front().last, count);
        for (std::size_t n = 0; n < tree.nodes().size(); ++n) {
          const MedianNode& node = tree.nodes()[n];
          Eigen::AlignedBox3d box;
          for (std::uint32_t i = node.first; i < node.last; ++i) box.extend(points[i]);
          EXPECT_EQ(node.box.min(), box.min()) << seed;
          EXPECT_EQ(node.box.max(), box.max()) << seed;
          EXPECT_EQ(node.right == 0, node.last - node.first <= kLeafSize);
          if (node.right == 0) continue;
          const MedianNode& left = tree.nodes()[n + 1];
          const MedianNode& right = tree.nodes()[node.right];
          EXPECT_EQ(left.first, node.first);
          EXPECT_EQ(left.last, node.first + (node.last - node.first) / 2);
          EXPECT_EQ(right.first, left.last);
          EXPECT_EQ(right.last, node.last);
          int axis = 0;
          box.sizes().maxCoeff(&axis);
          EXPECT_LE(left.box.max()[axis], right.box.min()[axis]) << seed;
        }
      }
    }
  }
}

TEST(MedianTree, SortsByThePlaceAndEnclosesTheExtent) {
  std::vector<Vec3> points = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  const auto extent_of = [](const Vec3& p) { return Eigen::AlignedBox3d(p - Vec3(0.1, 5.0, 0.0), p + Vec3(0.1, 7.0, 0.0)); };
  const MedianTree tree(points, 2, extent_of, [](const Vec3& p) -> Vec3 { return -p; });
  ASSERT_EQ(tree.nodes().size(), 3U);
  EXPECT_EQ(tree.nodes()[1].box.min(), Vec3(1.9, -5.0, 0.0));
  EXPECT_EQ(tree.nodes()[1].box.max(), Vec3(3.1, 7.0, 0.0));
}

// The items are numbers of points; most of the points are at the same place as others.
TEST(MedianTree, OfNumbersDoesNotDependOnTheirOrder) {
  const std::vector<Vec3> points = scattered_points(3, 500, true);
  const auto place_of = [&](std::uint32_t i) -> const Vec3& { return points[i]; };
  std::vector<std::uint32_t> items(points.size());
  std::iota(items.begin(), items.end(), 0U);
  std::vector<std::uint32_t> shuffled = items;
  std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937_64(4));
  const MedianTree tree(items, kLeafSize, place_of, place_of);
  const MedianTree other(shuffled, kLeafSize, place_of, place_of);
  ASSERT_EQ(tree.nodes().size(), other.nodes().size());
  for (const MedianNode& leaf : tree.nodes()) {
    if (leaf.right == 0) {
      EXPECT_TRUE(std::is_permutation(items.begin() + leaf.first, items.begin() + leaf.last, shuffled.begin() + leaf.first));
    }
  }
}

TEST(MedianTree, VisitsTheNearestFirst) {
  for (const std::uint64_t seed : {5U, 6U}) {
    std::vector<Vec3> points = scattered_points(seed, 2000, true);
    const MedianTree tree = tree_over(points);
    for (const Vec3& p : scattered_points(seed + 10, 50, false)) {
      std::size_t examined = 0;
      double nearest = std::numeric_limits<double>::infinity();
      tree.visit_nearest_first([&](std::uint32_t number) { return squared_distance(tree.nodes()[number], p); },
                               [&](double squared) { return squared < nearest; },
                               [&](const MedianNode& leaf) {
                                 for (std::uint32_t i = leaf.first; i < leaf.last; ++i) {
                                   nearest = std::min(nearest, (points[i] - p).squaredNorm());
                                   ++examined;
                                 }
                               });
      double expected = std::numeric_limits<double>::infinity();
      for (const Vec3& point : points) expected = std::min(expected, (point - p).squaredNorm());
      EXPECT_EQ(nearest, expected) << seed;
      EXPECT_LT(examined, points.size() / 10) << seed;
    }
  }
}

TEST(MedianTree, OfTwoAtTheSameDistanceVisitsTheLeftFirst) {
  std::vector<Vec3> points = scattered_points(7, 100, false);
  const MedianTree tree = tree_over(points);
  std::uint32_t next = 0;
  tree.visit_nearest_first([](std::uint32_t) { return 0.0; }, [](double) { return true; },
                           [&](const MedianNode& leaf) {
                             EXPECT_EQ(leaf.first, next);
                             next = leaf.last;
                           });
  EXPECT_EQ(next, points.size());
}

// Each query takes the points near `p` that no earlier query took.
TEST(MedianTree, VisitsWhatIsOpenAndCountsWhatIsFinished) {
  for (const std::uint64_t seed : {8U, 9U}) {
    std::vector<Vec3> points = scattered_points(seed, 2000, true);
    MedianTree tree = tree_over(points);
    std::vector<bool> is_taken(points.size(), false);
    for (const Vec3& p : scattered_points(seed + 10, 50, false)) {
      std::vector<std::uint32_t> expected;
      for (std::uint32_t i = 0; i < points.size(); ++i) {
        if (!is_taken[i] && (points[i] - p).norm() < 0.3) expected.push_back(i);
      }
      std::vector<std::uint32_t> found;
      tree.visit_open([&](const MedianNode& node) { return node.open_items != 0 && squared_distance(node, p) < 0.1; },
                      [&](std::uint32_t i) {
                        if (is_taken[i] || !((points[i] - p).norm() < 0.3)) return false;
                        found.push_back(i);
                        is_taken[i] = true;
                        return true;
                      });
      EXPECT_EQ(found, expected) << seed;
      for (const MedianNode& node : tree.nodes()) {
        EXPECT_EQ(node.open_items, std::count(is_taken.begin() + node.first, is_taken.begin() + node.last, false)) << seed;
      }
    }
  }
}

TEST(MedianTree, OfNothingHasNoNodes) {
  std::vector<Vec3> none;
  MedianTree tree = tree_over(none);
  EXPECT_TRUE(tree.nodes().empty());
  const auto fail = [](const auto&) { ADD_FAILURE(); };
  tree.visit_nearest_first([](std::uint32_t) { return 0.0; }, [](double) { return true; }, fail);
  tree.visit_open([](const MedianNode&) { return true; },
                  [&](std::uint32_t i) {
                    fail(i);
                    return false;
                  });
}

}  // namespace
}  // namespace hapton
