#include "core/tool/motion_energy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/tool/random_vector.h"

namespace hapton {
namespace {

constexpr unsigned kSeed = 218;
constexpr double kTurnLength = 0.3;

Vec6 shift_and_turn_of(const RigidMotion& motion) { return (Vec6() << motion.shift, motion.turn).finished(); }

class MotionEnergyTest : public testing::Test {
 protected:
  std::mt19937_64 random{kSeed};
  MotionEnergy energy{kTurnLength};

  RigidMotion draw() {
    const Vec3 shift = draw_in_cube(random);
    return {{}, shift, draw_in_cube(random)};
  }
};

TEST_F(MotionEnergyTest, OfTheCouplingAloneIsTheSquaredLength) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  for (int n = 0; n < 20; ++n) {
    const RigidMotion motion = draw();
    EXPECT_NEAR(energy.to_coordinates(motion).norm(), energy.length(motion), 1e-14);
    EXPECT_NEAR(energy.length(motion), std::hypot(motion.shift.norm(), kTurnLength * motion.turn.norm()), 1e-14);
    EXPECT_LT((energy.goal_of(motion) - energy.to_coordinates(motion)).norm(), 1e-14);
  }
}

TEST_F(MotionEnergyTest, HasTheCurvatureThatWasSetWithinItsBounds) {
  SCOPED_TRACE(testing::Message() << "seed " << kSeed);
  const Vec3 u = draw_in_cube(random).normalized();
  Mat6 contact_curvature = Mat6::Zero();
  contact_curvature.bottomRightCorner<3, 3>() = -2.0 * kTurnLength * kTurnLength * u * u.transpose();
  energy.set_curvature(energy.coupling_curvature() - contact_curvature);
  const Mat6 curvature = energy.coupling_curvature() - contact_curvature;
  for (int n = 0; n < 20; ++n) {
    const RigidMotion motion = draw();
    const Vec6 shift_and_turn = shift_and_turn_of(motion);
    EXPECT_NEAR(energy.to_coordinates(motion).squaredNorm(), shift_and_turn.dot(curvature * shift_and_turn), 1e-13);
    EXPECT_LT((shift_and_turn_of(energy.to_motion({}, energy.to_coordinates(motion))) - shift_and_turn).norm(), 1e-13);
    // In these coordinates, the pull of the coupling does the same work.
    const RigidMotion device_motion = draw();
    const Vec6 pull = energy.coupling_curvature() * shift_and_turn_of(device_motion);
    EXPECT_NEAR(energy.goal_of(device_motion).dot(energy.to_coordinates(motion)), pull.dot(shift_and_turn), 1e-13);
    const Vec6 row = shift_and_turn_of(draw());
    EXPECT_NEAR(energy.to_row(row).dot(energy.to_coordinates(motion)), row.dot(shift_and_turn), 1e-13);
  }
  energy.set_curvature(-energy.coupling_curvature());
  const RigidMotion motion = draw();
  EXPECT_NEAR(energy.to_coordinates(motion).squaredNorm(), 0.125 * std::pow(energy.length(motion), 2), 1e-13);
  energy.set_plain();
  EXPECT_NEAR(energy.to_coordinates(motion).norm(), energy.length(motion), 1e-14);
}

}  // namespace
}  // namespace hapton
