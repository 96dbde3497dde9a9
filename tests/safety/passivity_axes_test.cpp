// Compares one account of energy for all axes with one for each axis (decision 227): a mass in a plane, at a wall that may be turned.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "safety/passivity_controller.h"

namespace hapton {
namespace {

constexpr double kPeriodS = 1e-3;
constexpr double kDeviceKg = 0.075;
constexpr double kLimitN = 20.0;

// The controller that is used: one account for all axes.
struct OneAccount {
  explicit OneAccount(const PassivityController::Mechanics& device) : controller(device) {}
  void observe(const Vec3& moved_m) { controller.observe(kLimitN, moved_m); }
  Vec3 shape(const Vec3& wanted_n) { return controller.shape(wanted_n, 20.0); }
  void note_applied(const Vec3& force_n) { controller.note_applied(force_n, kPeriodS); }

  PassivityController controller;
};

// The alternative: a controller for each of the axes x and y.
struct AccountForEachAxis {
  explicit AccountForEachAxis(const PassivityController::Mechanics& device) : axes(2, PassivityController(device)) {}
  void observe(const Vec3& moved_m) {
    for (int i = 0; i < 2; ++i) axes[static_cast<std::size_t>(i)].observe(kLimitN, moved_m[i] * Vec3::Unit(i));
  }
  Vec3 shape(const Vec3& wanted_n) {
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 2; ++i) sum += axes[static_cast<std::size_t>(i)].shape(wanted_n[i] * Vec3::Unit(i), 20.0);
    return sum;
  }
  void note_applied(const Vec3& force_n) {
    for (int i = 0; i < 2; ++i) axes[static_cast<std::size_t>(i)].note_applied(force_n[i] * Vec3::Unit(i), kPeriodS);
  }

  std::vector<PassivityController> axes;
};

struct TurnedWall {
  double angle_rad = 0.0;  // from x to the wall's normal
  double stiffness_n_per_m = 1000.0;
  double friction = 0.0;  // Coulomb's coefficient
  int delay_samples = 0;
  double device_damping_ns_per_m = 0.0;
};

// Where the hand wants the device to be: along the normal and along the wall.
struct Goal {
  double normal_m = 0.0;
  double along_m = 0.0;
};

struct TouchResult {
  std::vector<double> normal_forces_n;
  double most_given_j = 0.0;
  double most_given_along_normal_j = 0.0;
  double squared_loss = 0.0;  // sum of squares of the part taken from the wanted force
  double squared_wanted = 0.0;
  double least_normal_m = 1.0;  // position of the device over the second half
  double most_normal_m = -1.0;

  double lost_share() const { return std::sqrt(squared_loss / squared_wanted); }
  double bounce_m() const { return most_normal_m - least_normal_m; }
};

template <class Account, class Hand>
TouchResult touch(const TurnedWall& wall, Hand&& goal_of) {
  constexpr int kSteps = 10'000;
  const Vec3 normal(std::cos(wall.angle_rad), std::sin(wall.angle_rad), 0.0);
  const Vec3 along(-normal.y(), normal.x(), 0.0);
  Account account({.mass_kg = kDeviceKg, .damping_ns_per_m = wall.device_damping_ns_per_m});
  std::deque<Vec3> delayed_n(static_cast<std::size_t>(wall.delay_samples), Vec3::Zero());
  Vec3 x = 1e-3 * normal;
  Vec3 v = Vec3::Zero();
  Vec3 moved_m = Vec3::Zero();
  double given_j = 0.0;
  double along_normal_j = 0.0;
  TouchResult result;
  for (int n = 0; n < kSteps; ++n) {
    account.observe(moved_m);
    const double pressed_n = std::clamp(-wall.stiffness_n_per_m * x.dot(normal), 0.0, kLimitN);
    delayed_n.push_back(pressed_n * (normal - wall.friction * std::tanh(v.dot(along) / 0.005) * along));
    const Vec3 wanted_n = delayed_n.front();
    delayed_n.pop_front();
    const Vec3 force_n = account.shape(wanted_n);
    const Goal goal = goal_of(n * kPeriodS);
    const Vec3 hand_n = 500.0 * (goal.normal_m * normal + goal.along_m * along - x) - 5.0 * v;
    const Vec3 a = (force_n + hand_n - wall.device_damping_ns_per_m * v) / (kDeviceKg + 0.15);
    moved_m = kPeriodS * v + 0.5 * kPeriodS * kPeriodS * a;
    x += moved_m;
    v += kPeriodS * a;
    account.note_applied(force_n);
    given_j += force_n.dot(moved_m);
    along_normal_j += force_n.dot(normal) * moved_m.dot(normal);
    result.most_given_j = std::max(result.most_given_j, given_j);
    result.most_given_along_normal_j = std::max(result.most_given_along_normal_j, along_normal_j);
    result.squared_loss += (force_n - wanted_n).squaredNorm();
    result.squared_wanted += wanted_n.squaredNorm();
    result.normal_forces_n.push_back(force_n.dot(normal));
    if (n < kSteps / 2) continue;
    result.least_normal_m = std::min(result.least_normal_m, x.dot(normal));
    result.most_normal_m = std::max(result.most_normal_m, x.dot(normal));
  }
  return result;
}

// A circle of 3 mm radius at 1 Hz, so that the wall takes energy by one motion and returns it by another.
Goal circle(double t_s) {
  const double angle = 2.0 * std::numbers::pi * t_s;
  return {-0.002 + 0.003 * std::cos(angle), 0.003 * std::sin(angle)};
}

// Back and forth along the wall at up to 100 mm/s, pressed 2 mm deep.
Goal slide(double t_s) { return {-0.002, 0.04 * std::sin(2.5 * t_s)}; }

constexpr double kWallAnglesRad[] = {0.0, 0.2, 0.5, std::numbers::pi / 4.0, 1.0};

TEST(PassivityAxes, AWallThatTheDeviceMakesPassiveIsFeltAsItIsInEachDirection) {
  const std::vector<double> straight = touch<OneAccount>({.device_damping_ns_per_m = 0.75}, circle).normal_forces_n;
  for (const double angle_rad : kWallAnglesRad) {
    const TouchResult result = touch<OneAccount>({.angle_rad = angle_rad, .device_damping_ns_per_m = 0.75}, circle);
    EXPECT_EQ(result.squared_loss, 0.0) << angle_rad;
    for (std::size_t i = 0; i < straight.size(); ++i)
      ASSERT_NEAR(result.normal_forces_n[i], straight[i], 1e-9) << angle_rad << ", step " << i;
  }
}

TEST(PassivityAxes, AnAccountForEachAxisTakesItsForceAwayUnlessItIsAlongAnAxis) {
  for (const double angle_rad : kWallAnglesRad) {
    const TouchResult result = touch<AccountForEachAxis>({.angle_rad = angle_rad, .device_damping_ns_per_m = 0.75}, circle);
    if (angle_rad == 0.0) {
      EXPECT_EQ(result.squared_loss, 0.0);
    } else {
      EXPECT_GT(result.lost_share(), 0.4) << angle_rad;
    }
  }
}

TEST(PassivityAxes, OverADelayASlopeStaysCalmWithOneAccountOnly) {
  for (const int delay : {5, 15, 100}) {
    const TurnedWall wall{.angle_rad = std::numbers::pi / 4.0, .stiffness_n_per_m = 1e5, .delay_samples = delay};
    const TouchResult one = touch<OneAccount>(wall, slide);
    EXPECT_LT(one.most_given_along_normal_j, 1e-9) << delay;
    EXPECT_LT(one.bounce_m(), 1e-5) << delay;
    const TouchResult each = touch<AccountForEachAxis>(wall, slide);
    EXPECT_GT(each.most_given_along_normal_j, 0.2) << delay;
    EXPECT_GT(each.bounce_m(), 3e-3) << delay;
  }
}

// The limit of one account: an unstable wall may give back along its normal what sliding friction has taken from the hand, but no
// more than that.
TEST(PassivityAxes, WithFrictionTheWholeStaysPassiveAndBounded) {
  for (const double friction : {0.3, 0.6}) {
    for (const int delay : {5, 15, 100}) {
      for (const double angle_rad : kWallAnglesRad) {
        const TouchResult result =
            touch<OneAccount>({.angle_rad = angle_rad, .stiffness_n_per_m = 1e5, .friction = friction, .delay_samples = delay}, slide);
        EXPECT_LT(result.most_given_j, 1e-9) << friction << ", " << delay << " ms, " << angle_rad;
        EXPECT_LT(result.bounce_m(), 0.01) << friction << ", " << delay << " ms, " << angle_rad;
      }
    }
  }
}

}  // namespace
}  // namespace hapton
