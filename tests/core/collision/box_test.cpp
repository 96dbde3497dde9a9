#include "core/collision/box.h"

#include <gtest/gtest.h>

#include <vector>

namespace hapton {
namespace {

TEST(Box, StartsEmptyAndGrows) {
  Box box;
  EXPECT_FALSE(box.overlaps(Box::around({-9, -9, -9}, {9, 9, 9})));
  box.grow({1, 2, 3});
  box.grow({-1, 0, 5});
  EXPECT_EQ(box.low, Vec3(-1, 0, 3));
  EXPECT_EQ(box.high, Vec3(1, 2, 5));
  EXPECT_EQ(box.centre(), Vec3(0, 1, 4));
  EXPECT_DOUBLE_EQ(box.diagonal(), std::sqrt(12.0));
}

TEST(Box, OfPointsIsTheSmallestThatHoldsThem) {
  const std::vector<Vec3> points = {{1, 2, 3}, {-1, 0, 5}, {0, 7, 4}};
  const Box box = Box::of(points);
  EXPECT_EQ(box.low, Vec3(-1, 0, 3));
  EXPECT_EQ(box.high, Vec3(1, 7, 5));
  const Box around = Box::around(points[0], points[1], points[2]);
  EXPECT_EQ(around.low, box.low);
  EXPECT_EQ(around.high, box.high);
  EXPECT_TRUE(Box::of({}).is_empty());
}

TEST(Box, TouchingBoxesOverlapAndSeparateOnesDoNot) {
  const Box box = Box::around({0, 0, 0}, {1, 1, 1});
  EXPECT_TRUE(box.overlaps(Box::around({1, 1, 1}, {2, 2, 2})));
  EXPECT_FALSE(box.overlaps(Box::around({1.001, 0, 0}, {2, 1, 1})));
  EXPECT_TRUE(box.inflated(0.01).overlaps(Box::around({1.001, 0, 0}, {2, 1, 1})));
}

TEST(Box, GrowsByBoxesAndAnEmptyOneAddsNothing) {
  Box box;
  EXPECT_TRUE(box.is_empty());
  box.grow(Box());
  EXPECT_TRUE(box.is_empty());
  box.grow(Box::around({0, 0, 0}, {1, 1, 1}));
  box.grow(Box());
  box.grow(Box::around({2, -1, 0}, {2, 0, 0}));
  EXPECT_FALSE(box.is_empty());
  EXPECT_EQ(box.low, Vec3(0, -1, 0));
  EXPECT_EQ(box.high, Vec3(2, 1, 1));
}

TEST(Box, DistanceIsToTheNearestPoint) {
  const Box box = Box::around({0, 0, 0}, {1, 2, 3});
  EXPECT_EQ(box.distance_squared({0.5, 1, 3}), 0.0);
  EXPECT_EQ(box.distance_squared({3, 1, -1}), 5.0);
  EXPECT_EQ(Box().distance_squared({0, 0, 0}), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace hapton
