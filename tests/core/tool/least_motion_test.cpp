#include "core/tool/least_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Dense>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

// Finds the optimum by trying every set of up to six active bounds.
class Enumeration {
 public:
  Enumeration(const Vec6& goal, const std::vector<MotionBound>& bounds) : goal_(goal), bounds_(bounds) { try_supersets(0); }
  const Vec6& best() const { return best_; }

 private:
  void try_supersets(std::size_t from) {
    try_active_set();
    if (active_set_.size() == 6) return;
    for (std::size_t i = from; i < bounds_.size(); ++i) {
      active_set_.push_back(i);
      try_supersets(i + 1);
      active_set_.pop_back();
    }
  }
  void try_active_set() {
    Vec6 y = goal_;
    if (!active_set_.empty()) {
      Eigen::MatrixXd rows(active_set_.size(), 6);
      Eigen::VectorXd shortfalls(active_set_.size());
      for (std::size_t k = 0; k < active_set_.size(); ++k) {
        rows.row(k) = bounds_[active_set_[k]].row;
        shortfalls[k] = bounds_[active_set_[k]].least - bounds_[active_set_[k]].row.dot(goal_);
      }
      const Eigen::VectorXd multipliers = (rows * rows.transpose()).fullPivLu().solve(shortfalls);
      if ((multipliers.array() < 0.0).any()) return;
      y += rows.transpose() * multipliers;
    }
    for (const MotionBound& bound : bounds_) {
      if (bound.row.dot(y) < bound.least - 1e-9) return;
    }
    if ((y - goal_).norm() < distance_) {
      distance_ = (y - goal_).norm();
      best_ = y;
    }
  }

  Vec6 goal_;
  const std::vector<MotionBound>& bounds_;
  std::vector<std::size_t> active_set_;
  Vec6 best_ = Vec6::Zero();
  double distance_ = std::numeric_limits<double>::infinity();
};

class LeastMotionTest : public testing::Test {
 protected:
  static constexpr unsigned kSeed = 2007;
  std::mt19937_64 random{kSeed};
  std::normal_distribution<double> normal;

  Vec6 draw() {
    Vec6 v;
    for (double& x : v) x = normal(random);
    return v;
  }
  // Half-spaces that contain zero, as those of a free tool's contacts do; most of their rows point against the goal.
  std::vector<MotionBound> draw_bounds(const Vec6& goal, std::size_t count) {
    std::vector<MotionBound> bounds(count);
    for (MotionBound& bound : bounds) {
      bound.row = (draw() - 0.8 * goal) * std::exp(normal(random));
      bound.least = -0.05 * std::abs(normal(random)) * bound.row.norm();
    }
    return bounds;
  }
};

TEST_F(LeastMotionTest, AgreesWithEnumerationOfAllActiveSets) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::array<int, 7> cases_by_active_count = {};
  for (int n = 0; n < 1500; ++n) {
    const Vec6 goal = draw();
    const std::vector<MotionBound> bounds = draw_bounds(goal, 1 + random() % 9);
    const LeastMotion found = find_least_motion(goal, bounds, 1e-12);
    ASSERT_TRUE(found.solved) << "case " << n;
    ASSERT_LE((found.y - Enumeration(goal, bounds).best()).norm(), 1e-7) << "case " << n;
    ++cases_by_active_count[found.active_count];
  }
  EXPECT_GT(*std::min_element(cases_by_active_count.begin() + 1, cases_by_active_count.end()), 5) << "each number of active bounds occurs";
}

TEST_F(LeastMotionTest, MultipliersBalanceTheMotion) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for (int n = 0; n < 200; ++n) {
    const Vec6 goal = draw();
    std::vector<MotionBound> bounds = draw_bounds(goal, 300);
    const auto copies = bounds;  // duplicates are linearly dependent
    bounds.insert(bounds.end(), copies.begin(), copies.end());
    const LeastMotion found = find_least_motion(goal, bounds, 1e-10);
    ASSERT_TRUE(found.solved) << "case " << n;
    Vec6 sum = goal;
    for (int k = 0; k < found.active_count; ++k) {
      ASSERT_GE(found.multipliers[k], -1e-12);
      sum += found.multipliers[k] * bounds[found.active[k]].row;
    }
    ASSERT_LE((sum - found.y).norm(), 1e-8) << "case " << n;
    for (const MotionBound& bound : bounds) ASSERT_GE(bound.row.dot(found.y), bound.least - 1e-9);
  }
}

TEST_F(LeastMotionTest, IsUnsolvedWhereBoundsContradictEachOther) {
  Vec6 up = Vec6::Zero();
  up[2] = 1.0;
  const std::vector<MotionBound> bounds = {{up, 0.1}, {-up, 0.1}};
  EXPECT_FALSE(find_least_motion(Vec6::Ones(), bounds, 1e-12).solved);
  EXPECT_TRUE(find_least_motion(Vec6::Ones(), {}, 1e-12).solved);
}

TEST_F(LeastMotionTest, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  const Vec6 goal = draw();
  const std::vector<MotionBound> bounds = draw_bounds(goal, 100);
  const AllocationGuard guard;
  const LeastMotion found = find_least_motion(goal, bounds, 1e-12);
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_TRUE(found.solved);
}

}  // namespace
}  // namespace hapton
