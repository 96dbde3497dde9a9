#include "safety/passivity_controller.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(PassivityController, LeavesAnAxisAloneThatOwesNothing) {
  PassivityController controller({});
  controller.observe(Vec3::Zero(), 0);
  EXPECT_EQ(controller.shape({1.0, -2.0, 3.0}, 0), Vec3(1.0, -2.0, 3.0));
  // Against all three forces.
  controller.observe({-1e-3, 1e-3, -1e-3}, kMs);
  EXPECT_EQ(controller.shape({5.0, -6.0, 7.0}, kMs), Vec3(5.0, -6.0, 7.0));
  EXPECT_EQ(controller.acted(), 0U);
  EXPECT_GT(controller.energy_j(), 0.0);
}

TEST(PassivityController, TakesADebtBackWithADamper) {
  PassivityController controller({.most_damping_ns_per_m = 100.0});
  controller.observe(Vec3::Zero(), 0);
  controller.shape({1.0, 0.0, 0.0}, 0);
  controller.observe({1e-3, 0.0, 0.0}, kMs);
  // It gave 1 mJ at 1 m/s: 1 Ns/m takes that back in the next millisecond.
  EXPECT_NEAR(controller.shape({1.0, 0.0, 0.0}, kMs).x(), -1.0, 1e-12);
  controller.observe({2e-3, 0.0, 0.0}, 2 * kMs);
  EXPECT_NEAR(controller.energy_j(), 0.0, 1e-15);
  EXPECT_NEAR(controller.worst_debt_j(), 1e-3, 1e-15);
  EXPECT_EQ(controller.acted(), 1U);
}

TEST(PassivityController, WhileAnAxisOwesItsForceOnlyOpposesTheMotion) {
  PassivityController controller({.most_damping_ns_per_m = 0.1});
  controller.observe(Vec3::Zero(), 0);
  controller.shape({5.0, 5.0, 0.0}, 0);
  controller.observe({1e-3, 0.0, 0.0}, kMs);
  const Vec3 shaped = controller.shape({5.0, 5.0, 0.0}, kMs);
  EXPECT_NEAR(shaped.x(), -0.1, 1e-12) << "bounded damper, no force along the motion";
  EXPECT_EQ(shaped.y(), 5.0) << "the other axis owes nothing";
  controller.observe({0.9e-3, 0.0, 0.0}, 2 * kMs);
  EXPECT_GT(controller.shape({5.0, 5.0, 0.0}, 2 * kMs).x(), 5.0) << "against the motion: kept";
}

TEST(PassivityController, CountsWhatIsWrittenInTheEnd) {
  PassivityController controller({});
  controller.observe(Vec3::Zero(), 0);
  controller.shape({10.0, 0.0, 0.0}, 0);
  controller.note_written({1.0, 0.0, 0.0});
  controller.observe({1e-3, 0.0, 0.0}, kMs);
  EXPECT_NEAR(controller.energy_j(), -1e-3, 1e-15);
}

}  // namespace
}  // namespace hapton
