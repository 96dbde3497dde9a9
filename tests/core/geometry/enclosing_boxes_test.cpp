#include "core/geometry/enclosing_boxes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <random>
#include <vector>

namespace hapton {
namespace {

using Box = EnclosingBoxes::Box;

Box cube(const Vec3& centre, double half) { return {centre - Vec3::Constant(half), centre + Vec3::Constant(half)}; }

TEST(EnclosingBoxes, AgreeWithBruteForce) {
  constexpr std::uint64_t kSeed = 17;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto random_box = [&](double size) {
    const Vec3 low(unit(random), unit(random), unit(random));
    return Box(low, low + size * Vec3(unit(random), unit(random), unit(random)));
  };
  for (const int count : {1, 4, 5, 300}) {
    std::vector<Box> boxes;
    for (int i = 0; i < count; ++i) boxes.push_back(random_box(0.5));
    EnclosingBoxes tree(boxes);
    int found = 0;
    for (int i = 0; i < 500; ++i) {
      const Box box = random_box(0.1);
      const bool is_contained = std::any_of(boxes.begin(), boxes.end(), [&](const Box& each) { return each.contains(box); });
      EXPECT_EQ(tree.contain(box), is_contained) << kSeed;
      found += is_contained ? 1 : 0;
    }
    EXPECT_EQ(found > 50, count == 300);
    for (const Box& box : boxes) EXPECT_TRUE(tree.contain(box)) << "itself";
  }
}

TEST(EnclosingBoxes, NoneContainsAnything) {
  EnclosingBoxes none({});
  EXPECT_FALSE(none.contain(cube(Vec3::Zero(), 1.0)));
  EXPECT_EQ(none.comparisons(), 0U);
}

TEST(EnclosingBoxes, OfSeparateBoxesAQueryExaminesFew) {
  std::vector<Box> boxes;
  for (int i = 0; i < 32; ++i) {
    for (int k = 0; k < 32; ++k) boxes.push_back(cube(Vec3(3.0 * i, 3.0 * k, 0.0), 1.0));
  }
  EnclosingBoxes tree(boxes);
  for (int i = 0; i < 32; ++i) {
    for (int k = 0; k < 32; ++k) {
      EXPECT_TRUE(tree.contain(cube(Vec3(3.0 * i, 3.0 * k, 0.0), 0.5)));
      EXPECT_FALSE(tree.contain(cube(Vec3(3.0 * i + 1.5, 3.0 * k, 0.0), 0.25))) << "between two";
    }
  }
  EXPECT_LT(tree.comparisons(), 2048U * 30U) << "10 levels of nodes; one by one: 1024 each";
}

TEST(EnclosingBoxes, OfNestedBoxesAQueryExaminesFew) {
  std::vector<Box> shells;
  for (int i = 1; i <= 1000; ++i) shells.push_back(cube(Vec3::Zero(), i));
  EnclosingBoxes tree(shells);
  for (int i = 1; i <= 1000; ++i) EXPECT_TRUE(tree.contain(cube(Vec3::Zero(), i - 0.5)));
  EXPECT_FALSE(tree.contain(cube(Vec3::Zero(), 1000.5)));
  EXPECT_LT(tree.comparisons(), 1000U * 30U);
}

}  // namespace
}  // namespace hapton
