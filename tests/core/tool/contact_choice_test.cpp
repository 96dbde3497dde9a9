#include "core/tool/contact_choice.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/tool_step.h"

namespace hapton {
namespace {

constexpr double kTolerance = 1e-10;

// Contacts at random points of a disc that faces up (`up` is 1) or down (-1), as bounds of its shift and its turn about the middle. Their
// `least` is random from 0 to `least`.
std::vector<MotionBound> make_face_bounds(std::size_t count, std::mt19937_64& random, double up = 1.0, double least = -1e-3) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::vector<MotionBound> bounds;
  while (bounds.size() < count) {
    const double x = unit(random);
    const double y = unit(random);
    if (x * x + y * y > 1.0) continue;
    MotionBound bound{.least = least * std::abs(unit(random))};
    bound.row << 0.0, 0.0, up, up * y, -up * x, 0.0;
    bounds.push_back(bound);
  }
  return bounds;
}

// The coupling's own metric, in which turns cost as much as shifts, made `stiffer` times as stiff, as the curvature of contacts can.
LocalContacts make_metric(double stiffer = 1.0) {
  LocalContacts metric;
  metric.tolerance = kTolerance;
  metric.is_blocked = false;
  metric.inverse_root /= std::sqrt(stiffer);
  return metric;
}

// The motion that LocalContacts::solve would find within these bounds, however many they are.
Vec6 motion_within(std::vector<MotionBound> bounds, const Vec6& goal, const LocalContacts& metric) {
  const double root = metric.inverse_root(0, 0);
  const auto find = [&](double scale, int& active_count) {
    std::vector<MotionBound> scaled = bounds;
    for (MotionBound& bound : scaled) bound.row *= scale;
    LeastMotion least = find_least_motion(scale * goal, scaled, kTolerance);
    if (!least.solved) {
      for (MotionBound& bound : scaled) bound.least = std::min(bound.least, 0.0);
      least = find_least_motion(scale * goal, scaled, kTolerance);
    }
    EXPECT_TRUE(least.solved);
    active_count = least.active_count;
    return Vec6(scale * least.y);
  };
  if (std::all_of(bounds.begin(), bounds.end(), [&](const MotionBound& b) { return b.row.dot(goal) >= b.least - kTolerance; })) return goal;
  int active_count = 0;
  const Vec6 curved = find(root, active_count);
  return active_count > 0 ? curved : find(1.0, active_count);
}

Placement placement_after(const Vec6& motion) { return RigidMotion{Placement(), motion.head<3>(), motion.tail<3>()}.at(1.0); }

// The largest difference, over all goals, between the motion within the chosen bounds and the motion within all bounds.
double find_error(const std::vector<MotionBound>& bounds, const std::vector<Vec6>& goals, const LocalContacts& metric) {
  std::array<std::uint32_t, LocalContacts::kMax> chosen;
  EXPECT_EQ(choose_contacts(bounds, goals, metric, chosen), LocalContacts::kMax);
  LocalContacts local = metric;
  for (const std::uint32_t number : chosen) local.add(bounds.at(number));
  double largest_error = 0.0;
  for (const Vec6& goal : goals) {
    largest_error = std::max(largest_error, (local.solve(placement_after(goal)).motion - motion_within(bounds, goal, metric)).norm());
  }
  return largest_error;
}

class ContactChoice : public testing::TestWithParam<unsigned> {
 protected:
  ContactChoice() : random_(GetParam()) { RecordProperty("seed", std::to_string(GetParam())); }
  // Goals that press by `depth`, randomly shifted and turned by about `aside` times the depth.
  std::vector<Vec6> draw_goals(std::size_t count, double depth, double aside = 0.1) {
    std::normal_distribution<double> normal;
    std::vector<Vec6> goals(count);
    for (Vec6& goal : goals) {
      for (int k = 0; k < 6; ++k) goal[k] = aside * depth * normal(random_);
      goal[2] -= depth;
    }
    return goals;
  }
  std::mt19937_64 random_;
};

TEST_P(ContactChoice, TheMotionIsThatWithinAllBounds) {
  for (const double stiffer : {1.0, 9.0}) {
    for (const std::size_t count : {65U, 300U, 3000U}) {
      const std::vector<MotionBound> bounds = make_face_bounds(count, random_);
      const std::vector<Vec6> goals = draw_goals(13, 1.0);
      EXPECT_LT(find_error(bounds, goals, make_metric(stiffer)), 1e-7) << count << " bounds, curvature " << stiffer;
      std::array<std::uint32_t, LocalContacts::kMax> chosen;
      choose_contacts(bounds, goals, make_metric(stiffer), chosen);
      std::sort(chosen.begin(), chosen.end());
      EXPECT_EQ(std::unique(chosen.begin(), chosen.end()), chosen.end());
    }
  }
}

// In a stiffer metric a motion is shorter, so it may meet no bound; the motion is then that of the plain metric.
TEST_P(ContactChoice, TheMotionIsThatOfThePlainMetricWhereTheOtherHasNoActiveBound) {
  std::vector<MotionBound> bounds = make_face_bounds(1000, random_);
  for (MotionBound& bound : bounds) bound.least = -0.01 - 1e-4 * bound.row.tail<3>().squaredNorm();  // the nearest in the middle
  for (int trial = 0; trial < 10; ++trial) EXPECT_LT(find_error(bounds, draw_goals(1, 0.1, 0.5), make_metric(64.0)), 1e-7);
}

// Between two faces, with less room in their middles than both contact offsets, and more room farther out.
TEST_P(ContactChoice, BoundsThatContradictEachOtherAreLowered) {
  for (const double stiffer : {1.0, 9.0}) {
    for (const std::size_t count : {50U, 500U, 2000U}) {
      std::vector<MotionBound> bounds;
      for (const double up : {1.0, -1.0}) {
        for (MotionBound bound : make_face_bounds(count, random_, up)) {
          bound.least = -1e-3 - 1e-4 * bound.row.tail<3>().squaredNorm();  // the nearest in the middle
          bounds.push_back(bound);
        }
        bounds.push_back({.row = up * Vec6::Unit(2), .least = 1e-5});
      }
      EXPECT_LT(find_error(bounds, draw_goals(13, 0.1), make_metric(stiffer)), 1e-7) << count << " bounds a face, curvature " << stiffer;
    }
  }
}

// For one goal, the motion is found however many cuts that takes, here within the faces of a ball.
TEST_P(ContactChoice, TheFirstGoalMayUseAllPlaces) {
  std::normal_distribution<double> normal;
  std::vector<MotionBound> bounds;
  for (int i = 0; i < 5000; ++i) {
    Vec6 row;
    for (int k = 0; k < 6; ++k) row[k] = normal(random_);
    bounds.push_back({.row = row.normalized(), .least = -1e-3});
  }
  EXPECT_LT(find_error(bounds, draw_goals(1, 1.0), make_metric()), 1e-5);
}

TEST_P(ContactChoice, TheOtherPlacesAreForTheBoundsWithTheLeastRoom) {
  const std::vector<MotionBound> bounds = make_face_bounds(500, random_);
  std::vector<std::uint32_t> expected(bounds.size());
  for (std::uint32_t i = 0; i < expected.size(); ++i) expected[i] = i;
  std::sort(expected.begin(), expected.end(), [&](std::uint32_t a, std::uint32_t b) { return bounds[a].least > bounds[b].least; });
  expected.resize(LocalContacts::kMax);
  std::sort(expected.begin(), expected.end());
  std::array<std::uint32_t, LocalContacts::kMax> chosen;
  ASSERT_EQ(choose_contacts(bounds, {}, make_metric(), chosen), LocalContacts::kMax);
  std::sort(chosen.begin(), chosen.end());
  EXPECT_TRUE(std::equal(chosen.begin(), chosen.end(), expected.begin()));
}

INSTANTIATE_TEST_SUITE_P(Seeds, ContactChoice, testing::Values(1U, 2U, 3U));

TEST(ContactChoiceOfFew, TakesAllAndNoMoreThanFit) {
  std::mt19937_64 random(5);
  const std::vector<MotionBound> bounds = make_face_bounds(5, random);
  const std::array<Vec6, 1> goals = {Vec6(-Vec6::Unit(2))};
  std::array<std::uint32_t, LocalContacts::kMax> chosen;
  EXPECT_EQ(choose_contacts(bounds, goals, make_metric(), chosen), 5U);
  EXPECT_EQ(choose_contacts({}, goals, make_metric(), chosen), 0U);
  EXPECT_EQ(choose_contacts(bounds, goals, make_metric(), std::span(chosen).first(2)), 2U);
}

// A box over a fine slab that moves: the bounds are those for the place where the slab will be.
TEST(LocalSetOfAMovingPart, HoldsTheToolWhereThePartWillBe) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  auto made =
      ToolStep::make(make_box({0.2, 0.2, 0.2}), {std::make_shared<TriangleMesh>(make_box({0.6, 0.6, 0.2}, 60))}, {}, {}, nullptr, {1});
  ASSERT_TRUE(made);
  ToolStep& step = **made;
  const double unit_m = step.scene().unit_m();
  NearFeatures near(step.tool(), step.moving(0));
  int held_trials = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Placement at = step.to_local({.X_WD = Pose(Eigen::Translation3d(0.0, 0.0, 0.2015))});
    step.proxy().reset(at);
    const double reach = 0.003 / unit_m;
    const std::array<Placement, 1> moved = {Placement{0.5 * reach * draw(), turn_by(4.0 * reach * draw())}};
    const Placement device{at.position + reach * (draw() - 2.0 * Vec3::UnitZ()), turn_by(8.0 * reach * draw())};
    LocalContacts local;
    step.proxy().find_local_contacts(device, moved, reach, local);
    ASSERT_EQ(local.count, LocalContacts::kMax);
    local.follow(moved);
    ASSERT_TRUE(near.collect(at, reach + ToolProxy::kContactOffset, 2.0 * reach / step.proxy().radius()));
    std::vector<MotionBound> all_bounds;
    for (const NearFeature& feature : near.features()) {
      if (!feature.is_minimum) continue;
      MotionBound bound{.least = ToolProxy::kContactOffset - feature.gap.distance};
      bound.row << feature.gap.normal, feature.gap.on_tool.cross(feature.gap.normal);
      const Vec3& point = feature.gap.on_scene;
      bound.least += feature.gap.normal.dot(moved[0].at(point) - point);
      for (int k = 0; k < 6; ++k) bound.row[k] *= local.plain_inverse_root[k];
      all_bounds.push_back(bound);
    }
    EXPECT_GT(all_bounds.size(), LocalContacts::kMax);
    Vec6 goal;
    goal << device.position - at.position, turn_between(at.orientation, device.orientation);
    const LeastMotion least =
        find_least_motion(local.plain_inverse_root.cwiseProduct(local.stiffness.cwiseProduct(goal)), all_bounds, local.tolerance);
    ASSERT_TRUE(least.solved);
    const Vec6 motion = local.plain_inverse_root.cwiseProduct(least.y);
    EXPECT_LT((local.solve(device).motion - motion).norm(), 1e-6 * reach) << "trial " << trial;
    held_trials += least.active_count > 0 ? 1 : 0;
  }
  EXPECT_GT(held_trials, 10);
}

}  // namespace
}  // namespace hapton
