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
  PassivityController controller({.mass_kg = 0.1, .most_damping_ns_per_m = 0.1});
  controller.observe(Vec3::Zero(), 0);
  controller.shape({5.0, 0.0, 0.0}, 0);
  controller.observe({1e-3, -1e-3, 0.0}, kMs);
  const Vec3 shaped = controller.shape({5.0, 5.0, 0.0}, kMs);
  EXPECT_NEAR(shaped.x(), -0.1, 1e-12) << "bounded damper, no force along the motion";
  EXPECT_EQ(shaped.y(), 5.0) << "the other axis owes nothing, and its force opposes its motion";
  // Against the motion of 50 mm/s: as much as stops 0.1 kg within the period, and the damper.
  controller.observe({0.95e-3, 0.0, 0.0}, 2 * kMs);
  EXPECT_NEAR(controller.shape({9.0, 0.0, 0.0}, 2 * kMs).x(), 0.1 * 0.05 / 1e-3 + 0.1 * 0.05, 1e-9);
}

// At rest with 2 mJ saved up, 0.1 kg, 1 ms: a force that gives 2 mJ to the mass in 1 ms is sqrt(2 E m) / T = 20 N.
TEST(PassivityController, BoundsAForceByWhatIsSavedUp) {
  PassivityController controller({.mass_kg = 0.1});
  controller.observe(Vec3::Zero(), 0);
  controller.shape({2.0, 0.0, 0.0}, 0);
  controller.observe({-1e-3, 0.0, 0.0}, kMs);
  controller.shape(Vec3::Zero(), kMs);
  controller.observe({-1e-3, 0.0, 0.0}, 2 * kMs);
  EXPECT_NEAR(controller.energy_j(), 2e-3, 1e-15);
  EXPECT_NEAR(controller.shape({50.0, 0.0, 0.0}, 2 * kMs).x(), 20.0, 1e-9);
  EXPECT_EQ(controller.shape({19.0, 0.0, 0.0}, 2 * kMs).x(), 19.0);
}

// What is written is what the bound promised: a mass that nobody holds never has more energy than was saved up.
TEST(PassivityController, AFreeMassGainsNoMoreThanWasTaken) {
  PassivityController controller({.mass_kg = 0.1});
  double x_m = 0.0;
  double v_m_per_s = -0.3;
  const double begin_j = 0.05 * v_m_per_s * v_m_per_s;
  for (int k = 0; k < 2000; ++k) {
    controller.observe({x_m, 0.0, 0.0}, k * kMs);
    // A wall of 100 N/mm whose force is 20 ms late would throw it out; here the worst: always out with all force.
    const double force_n = controller.shape({8.0, 0.0, 0.0}, k * kMs).x();
    x_m += 1e-3 * v_m_per_s + 0.5e-6 * force_n / 0.1;
    v_m_per_s += 1e-3 * force_n / 0.1;
    // Until the first motion is seen there is no bound: one period's work.
    if (k > 1) {
      EXPECT_LE(0.05 * v_m_per_s * v_m_per_s, begin_j * (1.0 + 1e-9) + 1e-3) << k;
    }
  }
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
