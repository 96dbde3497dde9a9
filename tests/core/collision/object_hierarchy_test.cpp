#include "core/collision/object_hierarchy.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr unsigned kHierarchySeed = 1112;

Box random_box(double largest, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  std::uniform_real_distribution<double> size(0.0, largest);
  const Vec3 low(place(random), place(random), place(random));
  return {low, low + Vec3(size(random), size(random), size(random))};
}

std::vector<Box> random_bounds(std::size_t count, double largest, std::mt19937_64& random) {
  std::vector<Box> boxes;
  while (boxes.size() < count) boxes.push_back(random_box(largest, random));
  return boxes;
}

// Exactly what a loop over all bounds finds, each object once.
void expect_same_as_brute_force(const ObjectHierarchy& hierarchy, const std::vector<Box>& boxes, std::mt19937_64& random) {
  for (int q = 0; q < 40; ++q) {
    const Box query = random_box(0.3, random);
    std::vector<std::uint32_t> found, expected;
    hierarchy.for_each_overlapping(query, [&](std::uint32_t o) { found.push_back(o); });
    for (std::uint32_t o = 0; o < boxes.size(); ++o) {
      if (boxes[o].overlaps(query)) expected.push_back(o);
    }
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, expected);

    const Vec3 p = 1.5 * query.low;
    double best = std::numeric_limits<double>::infinity();
    hierarchy.visit_nearest(p, best, [&](std::uint32_t o, double bound) {
      EXPECT_LT(boxes[o].distance_squared(p), bound);
      return best = std::min(bound, boxes[o].distance_squared(p));
    });
    double least = std::numeric_limits<double>::infinity();
    for (const Box& box : boxes) least = std::min(least, box.distance_squared(p));
    EXPECT_EQ(best, least);
  }
}

TEST(ObjectHierarchy, FindsWhatALoopOverAllObjectsFinds) {
  SCOPED_TRACE(testing::Message() << "seed " << kHierarchySeed);
  std::mt19937_64 random(kHierarchySeed);
  for (const std::size_t count : {0U, 1U, 2U, 8U, 9U, 70U, 1000U}) {
    const std::vector<Box> boxes = random_bounds(count, 0.2, random);
    expect_same_as_brute_force(ObjectHierarchy(boxes), boxes, random);
  }
}

TEST(ObjectHierarchy, ObjectsWithoutBoundsAreNeverFound) {
  std::mt19937_64 random(kHierarchySeed);
  std::vector<Box> boxes = random_bounds(50, 0.2, random);
  for (std::size_t i = 0; i < boxes.size(); i += 3) boxes[i] = Box();
  expect_same_as_brute_force(ObjectHierarchy(boxes), boxes, random);
  const std::vector<Box> none(20);
  expect_same_as_brute_force(ObjectHierarchy(none), none, random);
}

TEST(ObjectHierarchy, ARefitIsAsGoodAsANewHierarchy) {
  SCOPED_TRACE(testing::Message() << "seed " << kHierarchySeed);
  std::mt19937_64 random(kHierarchySeed);
  for (const std::size_t count : {1U, 9U, 300U}) {
    std::vector<Box> boxes = random_bounds(count, 0.1, random);
    ObjectHierarchy hierarchy(boxes);
    std::uniform_int_distribution<std::uint32_t> any_object(0, static_cast<std::uint32_t>(count) - 1);
    for (int round = 0; round < 20; ++round) {
      for (int moves = 0; moves < 10; ++moves) {
        const std::uint32_t o = any_object(random);
        const bool is_removed = moves == 9;
        boxes[o] = is_removed ? Box() : random_box(0.4, random);
        hierarchy.refit(o, boxes[o]);
        EXPECT_EQ(hierarchy.bounds(o).low, boxes[o].low);
      }
      expect_same_as_brute_force(hierarchy, boxes, random);
    }
  }
}

TEST(ObjectHierarchy, AVisitMayEndTheSearch) {
  const std::vector<Box> boxes(30, Box::around({0, 0, 0}, {1, 1, 1}));
  int visits = 0;
  ObjectHierarchy(boxes).for_each_overlapping(boxes[0], [&](std::uint32_t) { return ++visits < 3; });
  EXPECT_EQ(visits, 3);
}

TEST(ObjectHierarchy, QueriesAndRefitsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  std::mt19937_64 random(kHierarchySeed);
  const std::vector<Box> boxes = random_bounds(500, 0.1, random);
  ObjectHierarchy hierarchy(boxes);
  const AllocationGuard guard;
  for (std::uint32_t o = 0; o < 500; ++o) hierarchy.refit(o, boxes[499 - o]);
  int visited = 0;
  hierarchy.for_each_overlapping(Box::around({-1, -1, -1}, {2, 2, 2}), [&](std::uint32_t) { ++visited; });
  EXPECT_EQ(visited, 500);
  EXPECT_EQ(guard.count(), 0U);
}

}  // namespace
}  // namespace hapton
