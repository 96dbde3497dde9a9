#include "core/tool/local_contacts.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

MotionBound make_bound(const Vec3& normal, const Vec3& lever, double least) {
  MotionBound bound;
  bound.row << normal, lever.cross(normal);
  bound.least = least;
  return bound;
}

// A tool at the origin; a turn of one radian costs as much as a shift of `turn_length`.
LocalContacts make_local_contacts(double turn_length = 0.1) {
  LocalContacts local;
  local.is_blocked = false;
  local.tolerance = 1e-9;
  local.plain_inverse_root << Vec3::Ones(), Vec3::Constant(1.0 / turn_length);
  local.inverse_root = local.plain_inverse_root.asDiagonal();
  local.stiffness << Vec3::Ones(), Vec3::Constant(turn_length * turn_length);
  return local;
}

TEST(LocalContacts, LeavesTheDeviceAloneToTheBitWhereNothingHolds) {
  LocalContacts local = make_local_contacts();
  const Placement device{{0.01, -0.02, 0.03}, turn_by({0.1, 0.2, -0.1})};
  local.add(make_bound({0, 0, 1}, {0.05, 0, 0}, -0.02));
  const Placement at = local.constrain(device);
  EXPECT_EQ(at.position, device.position);
  EXPECT_EQ(at.orientation.coeffs(), device.orientation.coeffs());
}

TEST(LocalContacts, APlaneUnderTheMiddleHoldsOnlyTheDepth) {
  LocalContacts local = make_local_contacts();
  local.add(make_bound({0, 0, 1}, {0, 0, 0}, -0.001));
  const Placement at = local.constrain({{0.004, -0.003, -0.02}, turn_by({0.0, 0.0, 0.2})});
  EXPECT_LT((at.position - Vec3(0.004, -0.003, -0.001)).norm(), 1e-9);
  EXPECT_LT((turn_between(Quat::Identity(), at.orientation) - Vec3(0, 0, 0.2)).norm(), 1e-9);
}

// A contact off the middle also turns the tool: the energies of shift and turn determine the share of each.
TEST(LocalContacts, AContactWithALeverTurnsTheTool) {
  constexpr double kLever = 0.2;
  constexpr double kLength = 0.1;
  LocalContacts local = make_local_contacts(kLength);
  local.add(make_bound({0, 0, 1}, {kLever, 0, 0}, 0.0));
  const Placement at = local.constrain({{0, 0, -0.01}, Quat::Identity()});
  const double ratio = kLever * kLever / (kLength * kLength);
  EXPECT_NEAR(at.position.z(), -0.01 + 0.01 / (1.0 + ratio), 1e-9);
  EXPECT_NEAR(turn_between(Quat::Identity(), at.orientation).y(), -0.01 / (1.0 + ratio) * kLever / (kLength * kLength), 1e-9);
}

// Brute force: no nearby motion within the bounds has less energy.
TEST(LocalContacts, NoMotionNearbyIsBetter) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return Vec3(normal(random), normal(random), normal(random)); };
  for (int trial = 0; trial < 50; ++trial) {
    LocalContacts local = make_local_contacts();
    const int count = 1 + trial % 12;
    for (int n = 0; n < count; ++n) {
      local.add(make_bound((Vec3(0, 0, 2) + draw()).normalized(), 0.1 * draw(), -1e-3 * std::abs(normal(random))));
    }
    const Placement device{0.01 * draw() - Vec3(0, 0, 0.02), turn_by(0.05 * draw())};
    Vec6 goal;
    goal << device.position, turn_between(Quat::Identity(), device.orientation);
    const auto energy = [&](const Vec6& motion) { return local.stiffness.cwiseProduct(motion - goal).dot(motion - goal); };
    const auto is_allowed = [&](const Vec6& motion, double slack) {
      for (std::size_t i = 0; i < local.count; ++i) {
        if (local.bounds[i].row.dot(motion) < local.bounds[i].least - slack) return false;
      }
      return true;
    };
    const Placement at = local.constrain(device);
    Vec6 found_motion;
    found_motion << at.position, turn_between(Quat::Identity(), at.orientation);
    ASSERT_TRUE(is_allowed(found_motion, 1e-8)) << trial;
    const double least_energy = energy(found_motion);
    for (int n = 0; n < 5000; ++n) {
      Vec6 step;
      step << draw(), 10.0 * draw();
      const Vec6 nearby_motion = found_motion + 1e-4 * std::abs(normal(random)) * step;
      if (is_allowed(nearby_motion, 0.0)) {
        ASSERT_GE(energy(nearby_motion), least_energy - 1e-9 * (1.0 + least_energy)) << trial;
      }
    }
  }
}

TEST(LocalContacts, KeepsThoseWithTheLeastRoom) {
  LocalContacts local = make_local_contacts();
  for (std::size_t n = 0; n < 3 * LocalContacts::kMax; ++n) {
    local.add(make_bound({0, 0, 1}, {0, 0, 0}, -1e-3 * static_cast<double>(1 + (n * 37) % (3 * LocalContacts::kMax))));
  }
  EXPECT_EQ(local.count, LocalContacts::kMax);
  for (std::size_t i = 0; i < local.count; ++i) EXPECT_GE(local.bounds[i].least, -1e-3 * static_cast<double>(LocalContacts::kMax));
}

TEST(LocalContacts, ABlockedToolFollowsTheDeviceAndAHeldOneStays) {
  LocalContacts local;
  const Placement device{{1, 2, 3}, Quat::Identity()};
  EXPECT_EQ(local.constrain(device).position, device.position) << "nothing is known: no force";
  local = make_local_contacts();
  local.is_held = true;
  EXPECT_EQ(local.constrain(device).position, local.proxy.position);
}

// project() gives the nearest motion that the bounds allow; the expected motions are computed by hand.
TEST(LocalContacts, ProjectAMotionOntoTheirBounds) {
  LocalContacts local;
  local.is_blocked = false;
  local.tolerance = 1e-12;
  local.stiffness << Vec3::Ones(), Vec3::Constant(0.25);
  local.plain_inverse_root << Vec3::Ones(), Vec3::Constant(2.0);
  MotionBound floor, wall;
  floor.row << 0, 0, 1, 0, 0, 0;
  floor.least = 0.25;
  wall.row << 1, 0, 0, 0, 1, 0;
  local.add(floor);
  local.add(wall);
  Vec6 free = Vec6::Zero();
  free.head<3>() << 0.5, 0.1, 0.3;
  EXPECT_EQ(local.project(free), free);
  Vec6 below = free;
  below[2] = -0.5;
  Vec6 expected = below;
  expected[2] = 0.25;
  EXPECT_LT((local.project(below) - expected).norm(), 1e-12);
  // A motion into the wall by 0.5: shift and turn share the correction by their compliances, 1 and 4.
  Vec6 within = free;
  within[0] = -0.5;
  expected = within;
  expected[0] += 0.1;
  expected[4] += 0.4;
  EXPECT_LT((local.project(within) - expected).norm(), 1e-12);
}

}  // namespace
}  // namespace hapton
