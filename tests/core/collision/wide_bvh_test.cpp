#include "core/collision/wide_bvh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

std::vector<Box> random_boxes(std::size_t count, double largest, std::mt19937_64& random) {
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  std::uniform_real_distribution<double> size(0.0, largest);
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 low(place(random), place(random), place(random));
    boxes.push_back({low, low + Vec3(size(random), size(random), size(random))});
  }
  return boxes;
}

std::vector<std::uint32_t> items_overlapping(const WideBvh& tree, const Box& query) {
  std::vector<std::uint32_t> found;
  tree.for_each_overlapping(query, [&](std::uint32_t item) { found.push_back(item); });
  std::sort(found.begin(), found.end());
  return found;
}

// Every item that overlaps is found, once. Any other item found overlaps the query if that is grown by the rounding of single precision.
void expect_same_as_brute_force(const std::vector<Box>& boxes, const WideBvh& tree, const Box& query) {
  const std::vector<std::uint32_t> found = items_overlapping(tree, query);
  EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "an item was visited twice";
  const double rounding = 4e-6 * (query.high.cwiseAbs().maxCoeff() + query.low.cwiseAbs().maxCoeff() + 4.0);
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    const bool is_found = std::binary_search(found.begin(), found.end(), i);
    if (boxes[i].overlaps(query)) {
      EXPECT_TRUE(is_found) << "item " << i << " was missed";
    }
    if (is_found) {
      EXPECT_TRUE(boxes[i].overlaps(query.inflated(rounding))) << "item " << i << " is far from the query";
    }
  }
}

TEST(WideBvh, OverlapQueriesAgreeWithBruteForce) {
  constexpr unsigned kSeed = 1996;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (const std::size_t count : {1U, 7U, 8U, 9U, 64U, 65U, 1000U, 20000U}) {
    const std::vector<Box> boxes = random_boxes(count, 0.1, random);
    const WideBvh tree(boxes);
    for (const Box& query : random_boxes(60, 0.3, random)) expect_same_as_brute_force(boxes, tree, query);
  }
}

// Every item within the radius is found, once. Any other item found is farther only by the rounding of single precision.
TEST(WideBvh, BallQueriesAgreeWithBruteForce) {
  constexpr unsigned kSeed = 1997;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-1.2, 1.2);
  std::uniform_real_distribution<double> size(0.0, 0.4);
  for (const std::size_t count : {1U, 7U, 8U, 9U, 64U, 65U, 1000U, 20000U}) {
    const std::vector<Box> boxes = random_boxes(count, 0.1, random);
    const WideBvh tree(boxes);
    for (int k = 0; k < 60; ++k) {
      const Vec3 p(place(random), place(random), place(random));
      const double radius = k % 10 == 0 ? 0.0 : size(random);
      std::vector<std::uint32_t> found;
      tree.for_each_within(p, radius, [&](std::uint32_t item) {
        found.push_back(item);
        return true;
      });
      std::sort(found.begin(), found.end());
      EXPECT_EQ(std::adjacent_find(found.begin(), found.end()), found.end()) << "an item was visited twice";
      for (std::uint32_t i = 0; i < boxes.size(); ++i) {
        const double distance = (p - p.cwiseMax(boxes[i].low).cwiseMin(boxes[i].high)).norm();
        const bool is_found = std::binary_search(found.begin(), found.end(), i);
        if (distance <= radius) {
          EXPECT_TRUE(is_found) << "item " << i << " was missed";
        }
        if (is_found) {
          EXPECT_LE(distance, radius + 4e-6) << "item " << i << " is far from the ball";
        }
      }
    }
  }
}

TEST(WideBvh, ABallQueryEndsWhenTheVisitReturnsFalse) {
  std::mt19937_64 random(1998);
  const WideBvh tree(random_boxes(1000, 0.1, random));
  int visited = 0;
  tree.for_each_within(Vec3::Zero(), 10.0, [&](std::uint32_t) { return ++visited < 5; });
  EXPECT_EQ(visited, 5);
}

// Every near pair is found, once, from either item. No pair found is farther apart than the margin and the rounding of single precision.
void expect_near_pairs_as_brute_force(const std::vector<Box>& boxes, const WideBvh& tree, double margin) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> found;
  std::array<std::uint32_t, WideBvh::kWidth> first_items{};
  unsigned used_lanes = 0;
  tree.for_each_near_pair(
      margin,
      [&](const std::array<std::uint32_t, WideBvh::kWidth>& items, unsigned lanes) {
        first_items = items;
        used_lanes = lanes;
      },
      [&](std::uint32_t other, unsigned lanes) {
        EXPECT_EQ(lanes & ~used_lanes, 0U);
        for (int c = 0; c < WideBvh::kWidth; ++c) {
          if ((lanes >> c & 1U) == 0) continue;
          EXPECT_NE(first_items[c], other);
          EXPECT_TRUE(found.insert(std::minmax(first_items[c], other)).second) << first_items[c] << " and " << other << " were found twice";
        }
      });
  for (std::uint32_t i = 0; i < boxes.size(); ++i) {
    for (std::uint32_t j = 0; j < i; ++j) {
      const bool is_found = found.count({j, i}) != 0;
      if (boxes[i].inflated(margin).overlaps(boxes[j])) {
        EXPECT_TRUE(is_found) << i << " and " << j << " were missed";
      }
      if (is_found) {
        EXPECT_TRUE(boxes[i].inflated(margin + 1e-5).overlaps(boxes[j])) << i << " and " << j << " are far apart";
      }
    }
  }
}

TEST(WideBvh, NearPairsAgreeWithBruteForce) {
  constexpr unsigned kSeed = 2001;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (const std::size_t count : {0U, 1U, 2U, 7U, 8U, 9U, 64U, 65U, 300U, 1500U}) {
    for (const double margin : {0.0, 1e-8, 0.05}) {
      const std::vector<Box> boxes = random_boxes(count, 0.1, random);
      expect_near_pairs_as_brute_force(boxes, WideBvh(boxes), margin);
    }
  }
  // A refitted tree: some of its boxes have moved far, others have become empty.
  std::vector<Box> boxes = random_boxes(200, 0.1, random);
  WideBvh tree(boxes);
  const WideBvh::Parents parents = tree.find_parents();
  for (std::uint32_t i = 0; i < boxes.size(); i += 3) {
    boxes[i] = i % 2 == 0 ? Box{} : random_boxes(1, 0.2, random).front();
    tree.refit(i, boxes[i], parents);
  }
  expect_near_pairs_as_brute_force(boxes, tree, 0.01);
}

TEST(WideBvh, NearestAgreesWithBruteForce) {
  constexpr unsigned kSeed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  const std::vector<Box> boxes = random_boxes(5000, 0.02, random);
  const WideBvh tree(boxes);
  const auto distance_squared = [&](const Vec3& p, std::uint32_t i) {
    return (boxes[i].low - p).cwiseMax(p - boxes[i].high).cwiseMax(0.0).squaredNorm();
  };
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  for (int q = 0; q < 500; ++q) {
    const Vec3 p(place(random), place(random), place(random));
    double best_squared = std::numeric_limits<double>::infinity();
    std::size_t visits = 0;
    tree.visit_nearest(p, best_squared, [&](std::uint32_t item, double bound) {
      ++visits;
      best_squared = std::min(bound, distance_squared(p, item));
      return best_squared;
    });
    double expected_squared = std::numeric_limits<double>::infinity();
    for (std::uint32_t i = 0; i < boxes.size(); ++i) expected_squared = std::min(expected_squared, distance_squared(p, i));
    EXPECT_EQ(best_squared, expected_squared);
    EXPECT_LT(visits, boxes.size() / 4) << "the search skips too little";
  }
}

// An interrupted search finds the same items in the same order as one that is not interrupted, even if the bound shrinks meanwhile.
TEST(WideBvh, ANearestSearchThatIsInterruptedFindsTheSame) {
  constexpr unsigned kSeed = 222;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-1.2, 1.2);
  WideBvh::NearestSearch search;
  for (const std::size_t count : {0U, 1U, 9U, 1000U, 20000U}) {
    const WideBvh tree(random_boxes(count, 0.05, random));
    for (const double shrink : {1.0, 0.9}) {
      for (int k = 0; k < 40; ++k) {
        const Vec3 p(place(random), place(random), place(random));
        std::vector<std::uint32_t> expected;
        tree.visit_nearest(p, 0.09, [&](std::uint32_t item, double bound) {
          expected.push_back(item);
          return shrink * bound;
        });
        std::vector<std::uint32_t> found;
        double bound = 0.09;
        search.start(p);
        while (const auto item = search.next(tree, bound)) {
          found.push_back(*item);
          bound *= shrink;
          search = WideBvh::NearestSearch(search);  // a copy contains all that the search needs
        }
        ASSERT_EQ(found, expected) << count << " items";
      }
    }
  }
}

TEST(WideBvh, AnInfiniteQueryFindsEverythingOnce) {
  std::mt19937_64 random(6);
  const std::vector<Box> boxes = random_boxes(1001, 0.1, random);
  const WideBvh tree(boxes);
  for (const double far : {1e20, 1e200, HUGE_VAL}) {
    EXPECT_EQ(items_overlapping(tree, Box{Vec3::Constant(-far), Vec3::Constant(far)}).size(), boxes.size());
    EXPECT_TRUE(items_overlapping(tree, Box{Vec3::Constant(far), Vec3::Constant(far)}).empty());
  }
}

// Each of these trees has nodes with unused children, whose inverted infinite boxes no search may enter.
TEST(WideBvh, ABallOfAnyRadiusFindsEachItemOnce) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (const std::size_t count : {1U, 9U, 1001U}) {
    const WideBvh tree(random_boxes(count, 0.1, random));
    for (const double radius : {10.0, 1e19, 1e20, 1e200, HUGE_VAL}) {
      std::set<std::uint32_t> found;
      std::size_t visits = 0;
      tree.for_each_within(Vec3::Zero(), radius, [&](std::uint32_t item) {
        found.insert(item);
        return ++visits <= count;
      });
      EXPECT_EQ(visits, count) << "radius " << radius;
      EXPECT_EQ(found.size(), count) << "radius " << radius;
    }
  }
}

// The number of visits of all searches around p; each search ends at its first visit.
int visits_around(const WideBvh& tree, const Vec3& p) {
  int visits = 0;
  tree.for_each_within(p, 1.0, [&](std::uint32_t) { return ++visits < 0; });
  tree.visit_nearest(p, std::numeric_limits<double>::infinity(), [&](std::uint32_t, double) {
    ++visits;
    return 0.0;
  });
  WideBvh::NearestSearch search;
  search.start(p);
  return visits + (search.next(tree, 4.0) ? 1 : 0);
}

TEST(WideBvh, APointThatIsNotFiniteOrBeyondAFloatIsNearNothing) {
  constexpr unsigned kSeed = 9;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  for (const std::size_t count : {1U, 9U, 1001U}) {
    const WideBvh tree(random_boxes(count, 0.1, random));
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL, 1e39, -1e200}) {
      EXPECT_EQ(visits_around(tree, Vec3::Constant(bad)), 0) << bad;
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 p = Vec3::Zero();
        p[axis] = bad;
        EXPECT_EQ(visits_around(tree, p), 0) << bad << " along axis " << axis;
      }
    }
  }
}

TEST(WideBvh, DegenerateInputKeepsTheDepthBound) {
  std::vector<Box> same(100000, Box::around({0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}));
  const WideBvh all_the_same(same);
  EXPECT_LE(all_the_same.depth(), WideBvh::kMaxDepth);
  EXPECT_EQ(items_overlapping(all_the_same, same[0]).size(), same.size());

  // Each box is half as far away as the one before: a split by cost alone would separate one position at a time.
  std::vector<Box> shrinking;
  for (int i = 0; i < 4000; ++i) {
    const double x = std::ldexp(1.0, -(i % 120));
    shrinking.push_back(Box::around({x, 0, 0}, {1.01 * x, x, x}));
  }
  const WideBvh skewed(shrinking);
  EXPECT_LE(skewed.depth(), WideBvh::kMaxDepth);
  expect_same_as_brute_force(shrinking, skewed, Box::around({0, 0, 0}, {0.3, 0.1, 0.1}));

  const WideBvh none(std::span<const Box>{});
  EXPECT_TRUE(items_overlapping(none, Box::around({-1, -1, -1}, {1, 1, 1})).empty());
}

// The cut through the empty space costs least, even though it leaves most of the items on one side.
TEST(WideBvh, AFewItemsFarFromManyShareNoNodeWithThem) {
  constexpr std::size_t kMany = 10'000, kFew = 100;
  std::mt19937_64 random(23);
  std::vector<Box> boxes = random_boxes(kMany + kFew, 0.1, random);
  for (std::size_t i = kMany; i < boxes.size(); ++i) boxes[i] = {boxes[i].low + Vec3(500, 0, 0), boxes[i].high + Vec3(500, 0, 0)};
  const WideBvh tree(boxes);
  const WideBvh::Parents parents = tree.find_parents();
  std::vector<int> groups(tree.node_count(), 0);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    for (std::uint32_t at = parents.of_item[i]; at != WideBvh::kNoParent; at = parents.of_node[at / WideBvh::kWidth]) {
      groups[at / WideBvh::kWidth] |= i < kMany ? 1 : 2;
    }
  }
  EXPECT_EQ(groups[0], 3) << "the root";
  EXPECT_EQ(std::count(groups.begin(), groups.end(), 3), 1);
}

TEST(WideBvh, TreeOrderListsEveryItemOnceAndRenumberingFollows) {
  constexpr unsigned kSeed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::vector<Box> boxes = random_boxes(777, 0.1, random);
  WideBvh tree(boxes);
  const auto order = tree.items_in_tree_order();
  ASSERT_EQ(std::set<std::uint32_t>(order.begin(), order.end()).size(), boxes.size());
  std::vector<std::uint32_t> new_number(boxes.size());
  std::vector<Box> reordered;
  for (std::uint32_t i = 0; i < order.size(); ++i) {
    new_number[order[i]] = i;
    reordered.push_back(boxes[order[i]]);
  }
  tree.renumber_items(new_number);
  for (const Box& query : random_boxes(50, 0.3, random)) expect_same_as_brute_force(reordered, tree, query);
}

TEST(WideBvh, RefittedItemsAreFoundWhereTheyAreAndNowhereElse) {
  constexpr unsigned kSeed = 8;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::vector<Box> boxes = random_boxes(600, 0.1, random);
  WideBvh tree(boxes);
  const WideBvh::Parents parents = tree.find_parents();
  ASSERT_EQ(parents.of_item.size(), boxes.size());
  const std::vector<Box> new_boxes = random_boxes(600, 0.3, random);
  for (std::uint32_t i = 0; i < boxes.size(); i += 2) {
    boxes[i] = i % 6 == 0 ? Box() : new_boxes[i];
    tree.refit(i, boxes[i], parents);
  }
  for (const Box& query : random_boxes(60, 0.3, random)) expect_same_as_brute_force(boxes, tree, query);
  // All items move to one place: then no box above them may be larger than necessary.
  const std::vector<Box> places = random_boxes(600, 0.1, random);
  for (std::uint32_t i = 0; i < boxes.size(); ++i) tree.refit(i, places[0], parents);
  EXPECT_EQ(items_overlapping(tree, places[0]).size(), boxes.size());
  EXPECT_TRUE(items_overlapping(tree, Box::around({-3, -3, -3}, {-2, -2, -2})).empty());
}

TEST(WideBvh, QueriesUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  std::mt19937_64 random(3);
  const std::vector<Box> boxes = random_boxes(3000, 0.1, random);
  const WideBvh tree(boxes);
  std::size_t visited = 0;
  const AllocationGuard guard;
  tree.for_each_overlapping(Box::around({-1, -1, -1}, {1, 1, 1}), [&](std::uint32_t) { ++visited; });
  tree.for_each_within(Vec3::Zero(), 1.0, [&](std::uint32_t) { return ++visited > 0; });
  tree.visit_nearest({3, 0, 0}, 1e9, [&](std::uint32_t, double bound) {
    ++visited;
    return bound;
  });
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(visited, boxes.size() / 2);
}

// The time, 0 to 1 along the motion, at which a segment enters a box grown by `radius`; above 1: it does not enter.
double entry_time(const Box& box, const Vec3& p, const Vec3& motion, double radius) {
  const Box grown = box.inflated(radius);
  double enter = 0.0;
  double leave = 1.0;
  for (int k = 0; k < 3; ++k) {
    if (motion[k] == 0.0) {
      if (p[k] < grown.low[k] || p[k] > grown.high[k]) return 2.0;
      continue;
    }
    const double a = (grown.low[k] - p[k]) / motion[k];
    const double b = (grown.high[k] - p[k]) / motion[k];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : 2.0;
}

TEST(WideBvh, VisitsAllThatASegmentMeets) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> place(-1.2, 1.2);
  const std::vector<Box> boxes = random_boxes(3000, 0.1, random);
  const WideBvh tree(boxes);
  for (int i = 0; i < 400; ++i) {
    const Vec3 p(place(random), place(random), place(random));
    Vec3 motion = Vec3(place(random), place(random), place(random)) * std::pow(10.0, -static_cast<double>(i % 8));
    if (i % 5 == 0) motion[i % 3] = 0.0;
    if (i % 7 == 0) motion = Vec3::Zero();
    const double radius = i % 2 == 0 ? 0.0 : 0.01;
    std::set<std::uint32_t> visited;
    tree.visit_along(p, motion, radius, 1.0, [&](std::uint32_t item, double until) {
      EXPECT_TRUE(visited.insert(item).second);
      return until;
    });
    for (std::uint32_t item = 0; item < boxes.size(); ++item) {
      EXPECT_TRUE(entry_time(boxes[item], p, motion, radius) > 1.0 || visited.count(item) == 1) << "segment " << i << " item " << item;
    }
  }
}

TEST(WideBvh, VisitsThatShortenTheSegmentFindTheFirstBoxWithFewerVisits) {
  std::mt19937_64 random(22);
  std::uniform_real_distribution<double> place(-1.2, 1.2);
  const std::vector<Box> boxes = random_boxes(3000, 0.4, random);
  const WideBvh tree(boxes);
  std::size_t visits_shortened = 0;
  std::size_t visits_full = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 p(place(random), place(random), place(random));
    const Vec3 motion(place(random), place(random), place(random));
    double first_entry = 2.0;
    tree.visit_along(p, motion, 0.0, 1.0, [&](std::uint32_t item, double until) {
      ++visits_shortened;
      first_entry = std::min(first_entry, entry_time(boxes[item], p, motion, 0.0));
      return std::min(until, first_entry);
    });
    double expected = 2.0;
    for (const Box& box : boxes) expected = std::min(expected, entry_time(box, p, motion, 0.0));
    EXPECT_EQ(first_entry, expected) << i;
    tree.visit_along(p, motion, 0.0, 1.0, [&](std::uint32_t, double until) {
      ++visits_full;
      return until;
    });
  }
  EXPECT_LT(visits_shortened, visits_full / 2);
}

}  // namespace
}  // namespace hapton
