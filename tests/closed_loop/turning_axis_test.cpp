#include "closed_loop/turning_axis.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>

#include <gtest/gtest.h>

#include "closed_loop/zwidth.h"
#include "core/math/rotation_vector.h"
#include "devices/stylus_turn.h"

namespace hapton {
namespace {

// The hand of the simulated device.
constexpr HandModel kSimulatedHand{
    .mass_kg = 0.0, .damping_ns_per_m = StylusTurn::kHandNmSPerRad, .stiffness_n_per_m = StylusTurn::kHandNmPerRad};

// The share of a turn of 0.05 rad that is left after 2 s, while the motors render a spring at 1 kHz, delayed by whole periods: the largest
// turn in the last tenth of that time.
double turn_left(double nm_per_rad, int delay_periods) {
  constexpr std::int64_t kPeriodNs = 1'000'000;
  constexpr int kSteps = 2000;
  StylusTurn stylus;
  stylus.begin_at(turn_by(Vec3(0.05, 0.0, 0.0)));
  std::deque<Vec3> torques(static_cast<std::size_t>(delay_periods), Vec3::Zero());
  double largest = 0.0;
  for (int n = 0; n < kSteps; ++n) {
    const Vec3 turn = turn_between(Quat::Identity(), stylus.q_WT());
    torques.emplace_back(-nm_per_rad * turn);
    stylus.advance(n * kPeriodNs, (n + 1) * kPeriodNs, Quat::Identity(), torques.front());
    torques.pop_front();
    if (n >= kSteps * 9 / 10) largest = std::max(largest, turn.norm());
  }
  return largest / 0.05;
}

TEST(TurningAxis, HasTheInertiaOfTheSimulatedStylus) { EXPECT_EQ(turning_axis(0.17).mass_kg, StylusTurn::kInertiaKgM2); }

// turning_axis() and the simulated stylus have the same parameters: above the limit of the axis, turns of the stylus do not die
// out. The Euler steps of the simulation, 100 us, act half a step too early: a tenth of the delay of the hold.
TEST(TurningAxis, ItsLimitIsThatOfTheSimulatedStylus) {
  for (const int periods : {0, 1, 3, 10}) {
    const ZWidth width = find_zwidth({.device = turning_axis(0.0), .hand = kSimulatedHand, .rate_hz = 1000.0, .delay_s = 1e-3 * periods});
    const double limit = width.stiffness.value;
    EXPECT_LT(turn_left(0.9 * limit, periods), 0.5) << periods;
    EXPECT_GT(turn_left(1.2 * limit, periods), 2.0) << periods;
  }
}

TEST(TurningAxis, AHandHoldsAtItsLever) {
  const HandModel hand = turning_hand({.mass_kg = 0.15, .damping_ns_per_m = 5.0, .stiffness_n_per_m = 500.0});
  EXPECT_DOUBLE_EQ(hand.mass_kg, 3.75e-4);
  EXPECT_DOUBLE_EQ(hand.damping_ns_per_m, 0.0125);
  EXPECT_DOUBLE_EQ(hand.stiffness_n_per_m, 1.25);
}

// The limit is about b / (T/2 + delay), with the damping b of the hand; half of it is recommended.
TEST(TurningAxis, RecommendsHalfOfTheLimit) {
  const HandModel light = *find_hand_preset("light");
  const double b = turning_hand(light).damping_ns_per_m;
  EXPECT_NEAR(recommend_rotational_stiffness(light, 0.17, 1000.0, 5e-4), 0.5 * b / 1e-3, 0.01 * b / 1e-3);
  EXPECT_NEAR(recommend_rotational_stiffness(light, 0.17, 1000.0, 5e-3), 0.5 * b / 5.5e-3, 0.02 * b / 5.5e-3);
  EXPECT_LT(recommend_rotational_stiffness(light, 0.17, 250.0, 5e-3), recommend_rotational_stiffness(light, 0.17, 1000.0, 5e-3));
}

}  // namespace
}  // namespace hapton
