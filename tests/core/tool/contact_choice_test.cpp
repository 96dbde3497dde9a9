#include "core/tool/contact_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/tool/local_contacts.h"

namespace hapton {
namespace {

constexpr double kTolerance = 1e-10;

// Contacts of a face that looks up, on a disc, as bounds of shift and turn about its middle.
std::vector<MotionBound> face_of(std::size_t count, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<MotionBound> bounds;
  while (bounds.size() < count) {
    const double x = unit(random);
    const double y = unit(random);
    if (x * x + y * y > 1.0) continue;
    MotionBound bound{.least = -1e-3 * std::abs(unit(random))};
    bound.row << 0.0, 0.0, 1.0, y, -x, 0.0;
    bounds.push_back(bound);
  }
  return bounds;
}

class ContactChoice : public testing::TestWithParam<unsigned> {
 protected:
  ContactChoice() : random_(GetParam()) { RecordProperty("seed", std::to_string(GetParam())); }
  std::mt19937_64 random_;
};

TEST_P(ContactChoice, TheMotionIsThatWithinAllBounds) {
  std::normal_distribution<double> normal;
  for (const std::size_t count : {65U, 300U, 3000U}) {
    const std::vector<MotionBound> bounds = face_of(count, random_);
    std::vector<Vec6> goals;
    for (int g = 0; g < 13; ++g) {
      Vec6 goal;
      for (int k = 0; k < 6; ++k) goal[k] = 0.1 * normal(random_);
      goal[2] -= 1.0;  // pressed
      goals.push_back(goal);
    }
    std::array<std::uint32_t, LocalContacts::kMost> chosen;
    ASSERT_EQ(choose_contacts(bounds, goals, kTolerance, chosen), LocalContacts::kMost);
    std::vector<MotionBound> kept;
    for (const std::uint32_t number : chosen) kept.push_back(bounds.at(number));
    for (const Vec6& goal : goals) {
      const LeastMotion all = find_least_motion(goal, bounds, kTolerance);
      const LeastMotion least = find_least_motion(goal, kept, kTolerance);
      ASSERT_TRUE(all.solved && least.solved);
      EXPECT_LT((all.y - least.y).norm(), 1e-7) << count << " bounds";
    }
    std::sort(chosen.begin(), chosen.end());
    EXPECT_EQ(std::unique(chosen.begin(), chosen.end()), chosen.end());
  }
}

TEST_P(ContactChoice, TheRestAreThoseWithTheLeastRoom) {
  const std::vector<MotionBound> bounds = face_of(500, random_);
  std::vector<std::uint32_t> expected(bounds.size());
  for (std::uint32_t i = 0; i < expected.size(); ++i) expected[i] = i;
  std::sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) { return bounds[a].least > bounds[b].least; });
  expected.resize(LocalContacts::kMost);
  std::sort(expected.begin(), expected.end());
  std::array<std::uint32_t, LocalContacts::kMost> chosen;
  ASSERT_EQ(choose_contacts(bounds, {}, kTolerance, chosen), LocalContacts::kMost);
  std::sort(chosen.begin(), chosen.end());
  EXPECT_TRUE(std::equal(chosen.begin(), chosen.end(), expected.begin()));
}

INSTANTIATE_TEST_SUITE_P(Seeds, ContactChoice, testing::Values(1U, 2U, 3U));

TEST(ContactChoiceOfFew, TakesAllAndNoMoreThanFit) {
  std::mt19937_64 random(5);
  const std::vector<MotionBound> bounds = face_of(5, random);
  const std::array<Vec6, 1> goals = {Vec6(-Vec6::Unit(2))};
  std::array<std::uint32_t, LocalContacts::kMost> chosen;
  EXPECT_EQ(choose_contacts(bounds, goals, kTolerance, chosen), 5U);
  EXPECT_EQ(choose_contacts({}, goals, kTolerance, chosen), 0U);
  EXPECT_EQ(choose_contacts(bounds, goals, kTolerance, std::span(chosen).first(2)), 2U);
}

}  // namespace
}  // namespace hapton
