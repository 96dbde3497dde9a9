#include "vision_node/hull_edges.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

template <int K>
FdhHull<K> hull_of(const std::vector<Vec3>& points) {
  FdhHull<K> hull;
  for (const Vec3& p : points) hull.add(p);
  return hull;
}

TEST(HullEdges, ABoxHasTwelve) {
  const auto edges = find_hull_edges(hull_of<6>({Vec3(1.0, 2.0, 3.0), Vec3(2.0, 4.0, 7.0)}), 0.0);
  ASSERT_EQ(edges.size(), 12U);
  double length = 0.0;
  for (const auto& [from, to] : edges) length += (to - from).norm();
  EXPECT_NEAR(length, 4.0 * (1.0 + 2.0 + 4.0), 1e-9);
}

// The 14 directions include the normals of the faces of an octahedron, which are the directions to the corners of a cube.
TEST(HullEdges, AnOctahedronHasTwelveOfOneLength) {
  std::vector<Vec3> corners;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) corners.push_back(side * Vec3::Unit(axis));
  }
  const auto edges = find_hull_edges(hull_of<14>(corners), 0.0);
  ASSERT_EQ(edges.size(), 12U);
  for (const auto& [from, to] : edges) EXPECT_NEAR((to - from).norm(), std::sqrt(2.0), 1e-6);
}

// Euler: V - E + F = 2. At least three edges meet at each corner, so E is at most 3 (K - 2). All ends are within all planes.
TEST(HullEdges, OfAnyPointsLieOnTheHull) {
  std::mt19937 random(3);
  std::normal_distribution<double> coordinate(0.0, 0.1);
  for (int run = 0; run < 20; ++run) {
    std::vector<Vec3> points;
    for (int i = 0; i < 12; ++i) points.emplace_back(coordinate(random), 0.3 * coordinate(random), coordinate(random));
    const FdhHull<26> hull = hull_of<26>(points);
    const auto edges = find_hull_edges(hull, 0.0);
    EXPECT_GE(edges.size(), 12U);
    EXPECT_LE(edges.size(), 72U);
    for (const auto& [from, to] : edges) {
      for (const Vec3& end : {from, to}) {
        const auto along = fdh_project<26>(end);
        int planes = 0;
        for (std::size_t i = 0; i < along.size(); ++i) {
          EXPECT_GE(along[i], hull.low[i] - 1e-7);
          EXPECT_LE(along[i], hull.high[i] + 1e-7);
          planes += along[i] - hull.low[i] < 1e-7 || hull.high[i] - along[i] < 1e-7 ? 1 : 0;
        }
        EXPECT_GE(planes, 3) << "a corner is on three planes";
      }
    }
  }
}

TEST(HullEdges, AFlatOneIsGrownAndAnEmptyOneHasNone) {
  EXPECT_GE(find_hull_edges(hull_of<14>({Vec3(0.0, 0.0, 1.0), Vec3(1.0, 0.0, 1.0), Vec3(0.0, 1.0, 1.0)})).size(), 9U);
  EXPECT_TRUE(find_hull_edges(std::vector<HullSlab>()).empty());
}

}  // namespace
}  // namespace hapton
