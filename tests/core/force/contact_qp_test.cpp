#include "core/force/contact_qp.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hapton {
namespace {

// The optimum, by trying every set of up to three planes: of the feasible points, the one nearest to the goal.
Vec3 solve_by_enumeration(const Vec3& goal, const std::vector<ContactPlane>& planes, double tolerance) {
  Vec3 best = Vec3::Zero();
  double best_distance = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Vec3& y) {
    if (!y.allFinite()) return;
    for (const ContactPlane& plane : planes) {
      if (plane.normal.dot(y) < plane.height - tolerance) return;
    }
    if ((y - goal).norm() < best_distance) {
      best_distance = (y - goal).norm();
      best = y;
    }
  };
  const auto n = static_cast<int>(planes.size());
  consider(goal);
  for (int i = 0; i < n; ++i) {
    consider(goal + (planes[i].height - planes[i].normal.dot(goal)) * planes[i].normal);
    for (int j = i + 1; j < n; ++j) {
      Eigen::Matrix<double, 2, 3> two;
      two << planes[i].normal.transpose(), planes[j].normal.transpose();
      const Eigen::Vector2d missing(planes[i].height - planes[i].normal.dot(goal), planes[j].height - planes[j].normal.dot(goal));
      consider(goal + two.transpose() * (two * two.transpose()).fullPivLu().solve(missing));
      for (int k = j + 1; k < n; ++k) {
        Mat3 three;
        three << planes[i].normal.transpose(), planes[j].normal.transpose(), planes[k].normal.transpose();
        consider(three.fullPivLu().solve(Vec3(planes[i].height, planes[j].height, planes[k].height)));
      }
    }
  }
  return best;
}

TEST(ContactQp, AgreesWithEnumerationOfAllActiveSets) {
  constexpr unsigned kSeed = 1995;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  int three_active = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 goal(normal(random), normal(random), normal(random));
    std::vector<ContactPlane> planes(1 + random() % 7);
    for (ContactPlane& plane : planes) {
      // Half-spaces that contain zero, as planes at the proxy do, with normals leaning against the goal.
      plane.normal = (Vec3(normal(random), normal(random), normal(random)) - 0.7 * goal).normalized();
      plane.height = -0.05 * std::abs(normal(random));
    }
    const ConstrainedMotion solution = constrain_motion(goal, planes);
    ASSERT_TRUE(solution.solved) << "case " << i;
    EXPECT_LE((solution.motion - solve_by_enumeration(goal, planes, 1e-12)).norm(), 1e-9) << "case " << i;
    Vec3 correction = Vec3::Zero();
    for (int k = 0; k < solution.active_count; ++k) {
      EXPECT_GE(solution.multipliers[k], 0.0);
      correction += solution.multipliers[k] * planes[solution.active[k]].normal;
    }
    EXPECT_LE((solution.motion - goal - correction).norm(), 1e-9);
    three_active += solution.active_count == 3 ? 1 : 0;
  }
  EXPECT_GT(three_active, 100);
}

TEST(ContactQp, OrderOfThePlanesDoesNotMatter) {
  constexpr unsigned kSeed = 8;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 goal(normal(random), normal(random), normal(random));
    std::vector<ContactPlane> planes(2 + random() % 5);
    for (ContactPlane& plane : planes) plane.normal = (Vec3(normal(random), normal(random), normal(random)) - goal).normalized();
    const Vec3 one = constrain_motion(goal, planes).motion;
    std::reverse(planes.begin(), planes.end());
    EXPECT_LE((constrain_motion(goal, planes).motion - one).norm(), 1e-12);
  }
}

TEST(ContactQp, NearlyParallelPlanesLeaveTheirCommonDirectionExact) {
  for (const double tilt : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const std::vector<ContactPlane> valley = {{Vec3(tilt, 0, 1).normalized(), 0.0}, {Vec3(-tilt, 0, 1).normalized(), 0.0}};
    const ConstrainedMotion solution = constrain_motion(Vec3(0, 0.5, -1), valley);
    EXPECT_LE((solution.motion - Vec3(0, 0.5, 0)).norm(), 1e-9) << "tilt " << tilt;
  }
}

// A point a little off a convex edge is lifted off both faces. Terms of the solution cancel down to the angle between the planes.
TEST(ContactQp, LiftsOffNearlyParallelPlanes) {
  constexpr unsigned kSeed = 7;
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> exponent(-7.0, -0.5);
  const double height = 0x1p-30;
  for (int i = 0; i < 4000; ++i) {
    const double angle = std::pow(10.0, exponent(random));
    const Vec3 first = Vec3(normal(random), normal(random), normal(random)).normalized();
    std::vector<ContactPlane> planes = {{first, height}};
    for (int k = 1; k < (i % 2 == 0 ? 2 : 3); ++k) {
      const Vec3 beside = first.cross(Vec3(normal(random), normal(random), normal(random))).normalized();
      planes.push_back({(std::cos(angle) * first + std::sin(angle) * beside).normalized(), height * (1.0 + 0.1 * angle * normal(random))});
    }
    const ConstrainedMotion solution = constrain_motion(Vec3::Zero(), planes);
    ASSERT_TRUE(solution.solved) << "case " << i << ", angle " << angle;
    for (const ContactPlane& plane : planes) ASSERT_GE(plane.normal.dot(solution.motion), plane.height - 1e-14 * height) << "case " << i;
    ASSERT_LE(solution.motion.norm(), 4.0 * height) << "case " << i;
  }
}

TEST(ContactQp, WithoutPlanesTheGoalIsReached) {
  const Vec3 goal(0.1, -0.2, 0.3);
  EXPECT_EQ(constrain_motion(goal, {}).motion, goal);
  const std::vector<ContactPlane> behind = {{Vec3(0, 0, 1), 0.0}};
  const ConstrainedMotion solution = constrain_motion(goal, behind);
  EXPECT_EQ(solution.motion, goal);
  EXPECT_EQ(solution.active_count, 0);
}

TEST(ContactQp, ThreePlanesThatFormAPitLeaveNoMotion) {
  const std::vector<ContactPlane> pit = {
      {Vec3(1, 0, 1).normalized(), 0.0}, {Vec3(-1, 1, 1).normalized(), 0.0}, {Vec3(0, -1, 1).normalized(), 0.0}};
  const ConstrainedMotion solution = constrain_motion(Vec3(0.01, 0.02, -1), pit);
  EXPECT_TRUE(solution.solved);
  EXPECT_EQ(solution.active_count, 3);
  EXPECT_LE(solution.motion.norm(), 1e-15);
}

// A lift out of a groove of 0.1 to 0.001 radians, whose walls are not at quite the same distance: at a hundredth of a radian, the shortest
// lift is two hundred times the distance that it gains from each wall.
TEST(ContactQp, LiftsOutOfANarrowGroove) {
  constexpr std::uint64_t kSeed = 20261123;
  SCOPED_TRACE(kSeed);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int round = 0; round < 5000; ++round) {
    const Vec3 one = Vec3(uniform(random), uniform(random), uniform(random)).normalized();
    const Vec3 aside = one.cross(Vec3(uniform(random), uniform(random), uniform(random))).normalized();
    const double angle = std::pow(10.0, -1.0 - 2.0 * std::fabs(uniform(random)));
    const Vec3 other = (-std::cos(angle) * one + std::sin(angle) * aside).normalized();
    const double height = 5.7e-14;
    const std::array<ContactPlane, 2> walls{{{other, height * (1.0 + 0.1 * uniform(random))}, {one, height}}};
    const ConstrainedMotion lift = constrain_motion(Vec3::Zero(), walls);
    ASSERT_TRUE(lift.solved) << round << " " << angle;
    for (const ContactPlane& wall : walls) EXPECT_NEAR(wall.normal.dot(lift.motion), wall.height, 1e-3 * height) << round;
    EXPECT_NEAR(lift.motion.norm() * std::sin(0.5 * angle), height, 0.2 * height) << round;
  }
}

}  // namespace
}  // namespace hapton
