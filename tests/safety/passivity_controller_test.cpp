#include "safety/passivity_controller.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr double kMassKg = 0.075;
constexpr double kMaxForceN = 20.0;

// A mass at a wall (x < 0) along one axis. The wall is sampled; its forces are late by whole samples, and may be lost at random. The motion
// between two samples is exact if the force of the hand is held, too.
struct WallRun {
  double stiffness = 1000.0;
  double period_s = 1e-3;
  int delay_samples = 0;
  double loss = 0.0;
  double mass_kg = kMassKg;  // of the device and what the hand adds to it
  double damping = 0.0;      // of the device
  bool is_controlled = true;
  double x = 1e-3;
  double v = -0.1;

  double most_j = 0.0;         // most energy given to the hand at any time of the run
  double most_excess_j = 0.0;  // energy in one period that the hand's own pull explains
  double deepest_m = 0.0;
  double farthest_m = 0.0;
  double most_taken_n = 0.0;  // largest part taken from a wanted force
  double fastest = 0.0;
  int limited_steps = 0;
  int contact_steps = 0;

  template <class Hand>
  void run(int steps, std::uint64_t seed, Hand&& hand) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> chance(0.0, 1.0);
    PassivityController controller({.mass_kg = kMassKg, .damping_ns_per_m = damping});
    std::deque<double> delayed_n(static_cast<std::size_t>(delay_samples), 0.0);
    double wanted_n = 0.0;
    double given_j = 0.0;
    double moved_m = 0.0;
    double force_n = 0.0;
    for (int n = 0; n < steps; ++n) {
      controller.observe(kMaxForceN, Vec3(moved_m, 0, 0));
      delayed_n.push_back(std::min(kMaxForceN, std::max(0.0, -stiffness * x)));
      if (chance(random) >= loss) wanted_n = delayed_n.front();
      delayed_n.pop_front();
      force_n = is_controlled ? controller.shape(Vec3(wanted_n, 0, 0), 20.0).x() : wanted_n;
      most_taken_n = std::max(most_taken_n, std::abs(wanted_n - force_n));
      fastest = std::max(fastest, std::abs(v));
      limited_steps += is_controlled && controller.has_limited() ? 1 : 0;
      contact_steps += wanted_n > 0.0 ? 1 : 0;
      const double hand_n = hand(n * period_s, x, v);
      const double a = (force_n + hand_n - damping * v) / mass_kg;
      moved_m = v * period_s + 0.5 * a * period_s * period_s;
      x += moved_m;
      v += a * period_s;
      controller.note_applied(Vec3(force_n, 0, 0), period_s);
      given_j += force_n * moved_m;
      most_excess_j = std::max(most_excess_j, std::abs(force_n * hand_n) * period_s * period_s / (2.0 * kMassKg));
      most_j = std::max(most_j, given_j);
      deepest_m = std::max(deepest_m, -x);
      farthest_m = std::max(farthest_m, x);
    }
  }
};

double no_hand(double, double, double) { return 0.0; }

// A hand that presses with up to 3 N and comes back in a second.
double press(double t, double, double v) { return -3.0 * std::pow(std::sin(std::numbers::pi * t), 2) - 8.0 * v; }

// A held force lags half a period behind the spring, so a sampled spring gives back more than it stored: a power of K T / 2 v^2.
TEST(PassivityController, LeavesAWallThatTheDeviceMakesPassiveAsItIs) {
  for (const double stiffness : {100.0, 1000.0, 3000.0}) {
    for (const double rate_hz : {1000.0, 4000.0}) {
      WallRun run;
      run.stiffness = stiffness;
      run.period_s = 1.0 / rate_hz;
      run.damping = 1.5 * stiffness * run.period_s / 2.0;
      run.mass_kg = 0.2;
      run.x = 0.0;
      run.v = 0.0;
      run.run(static_cast<int>(2.0 * rate_hz), 1, press);
      EXPECT_GT(run.contact_steps, 0.5 * rate_hz);
      EXPECT_LE(run.most_taken_n, 2.0 * stiffness * run.fastest * run.period_s) << stiffness << " N/m, " << rate_hz << " Hz";
      EXPECT_GT(run.fastest, 0.002);
    }
  }
}

// Without damping, the credit is used up on the way out at a depth of about sqrt(2 v T d), d being the deepest; there the force ends.
TEST(PassivityController, OfAnUndampedWallItTakesWhatSamplingAdds) {
  for (const double rate_hz : {1000.0, 4000.0}) {
    WallRun run;
    run.period_s = 1.0 / rate_hz;
    run.mass_kg = 0.2;
    run.x = 0.0;
    run.v = 0.0;
    run.run(static_cast<int>(2.0 * rate_hz), 1, press);
    EXPECT_GT(run.limited_steps, 0);
    EXPECT_LE(run.most_taken_n, 1.5 * run.stiffness * std::sqrt(2.0 * run.fastest * run.period_s * run.deepest_m)) << rate_hz << " Hz";
  }
}

TEST(PassivityController, AFreeMassLeavesAStiffWallNoFasterThanItCame) {
  for (const double stiffness : {1e3, 1e4, 1e5, 1e6}) {
    for (const double speed : {0.01, 0.1, 0.5}) {
      WallRun uncontrolled;
      uncontrolled.stiffness = stiffness;
      uncontrolled.v = -speed;
      uncontrolled.is_controlled = false;
      WallRun controlled = uncontrolled;
      controlled.is_controlled = true;
      uncontrolled.run(200, 1, no_hand);
      controlled.run(200, 1, no_hand);
      const double energy_j = 0.5 * kMassKg * speed * speed;
      EXPECT_LE(controlled.most_j, 1e-12 * energy_j) << stiffness << " N/m, " << speed << " m/s";
      EXPECT_LE(std::abs(controlled.v), speed * (1.0 + 1e-12));
      if (stiffness <= 1e4) {
        EXPECT_GT(uncontrolled.most_j, 0.001 * energy_j) << "without the controller the wall is a source, so the test can fail";
      }
    }
  }
}

// A hand holds the device against the wall: without the controller this is a limit cycle.
TEST(PassivityController, AnyDelayLossOrStiffnessMakesNoSource) {
  for (const int delay : {0, 1, 10, 100, 500}) {
    for (const double loss : {0.0, 0.3}) {
      for (std::uint64_t seed = 1; seed <= 4; ++seed) {
        WallRun run;
        run.stiffness = 1e5;
        run.delay_samples = delay;
        run.loss = loss;
        run.mass_kg = 0.225;
        run.run(20'000, seed, [](double, double x, double v) { return -500.0 * (x + 0.002) - 5.0 * v; });
        EXPECT_LE(run.most_j, 4.0 * run.most_excess_j) << "delay " << delay << " ms, loss " << loss << ", seed " << seed;
        EXPECT_LT(run.farthest_m, 0.002) << "it is never thrown off the wall farther than the hand began";
        EXPECT_GT(run.contact_steps, 1000);
      }
    }
  }
}

TEST(PassivityController, WithoutItTheSameLoopIsASource) {
  WallRun run;
  run.stiffness = 1e5;
  run.delay_samples = 10;
  run.mass_kg = 0.225;
  run.is_controlled = false;
  run.run(20'000, 1, [](double, double x, double v) { return -500.0 * (x + 0.002) - 5.0 * v; });
  EXPECT_GT(run.most_j, 0.1);
}

TEST(PassivityController, ADeficitIsTakenBackByDamping) {
  PassivityController controller({.mass_kg = kMassKg});
  controller.note_applied(Vec3(1, 0, 0), 1e-3);
  controller.observe(kMaxForceN, Vec3(1e-4, 0, 0));  // a hand pulls the device away at 0.1 m/s
  EXPECT_DOUBLE_EQ(controller.given_j(), 1e-4);
  const Vec3 force = controller.shape(Vec3(0, 2, 0), 20.0);
  EXPECT_EQ(force.y(), 0.0) << "no credit: nothing along a direction in which it does not move";
  EXPECT_DOUBLE_EQ(force.x(), -1e-4 / (1e-3 * 0.01) * 0.1) << "the whole deficit within the period";
  EXPECT_TRUE(controller.has_limited());
  controller.note_applied(force, 1e-3);
  controller.observe(kMaxForceN, Vec3(1e-4, 0, 0));
  EXPECT_NEAR(controller.given_j(), 0.0, 1e-18);
}

TEST(PassivityController, DampingIsWhatTheDeviceBears) {
  PassivityController controller({.mass_kg = kMassKg});
  controller.note_applied(Vec3(10, 0, 0), 1e-3);
  controller.observe(kMaxForceN, Vec3(1e-4, 0, 0));
  EXPECT_DOUBLE_EQ(controller.shape(Vec3(0, 1e-9, 0), 3.0).x(), -3.0 * 0.1);
  EXPECT_DOUBLE_EQ(controller.shape(Vec3(0, 1e-9, 0), 1e9).x(), -kMassKg / 1e-3 * 0.1) << "no more than stops the mass";
}

TEST(PassivityController, CreditEndsWithTheContactAndADeficitStays) {
  PassivityController controller({.mass_kg = kMassKg});
  controller.note_applied(Vec3(1, 0, 0), 1e-3);
  controller.observe(kMaxForceN, Vec3(-1e-3, 0, 0));
  EXPECT_DOUBLE_EQ(controller.given_j(), -1e-3);
  controller.note_applied(Vec3::Zero(), 1e-3);
  controller.observe(kMaxForceN, Vec3(1e-3, 0, 0));
  EXPECT_EQ(controller.given_j(), 0.0);
  controller.note_applied(Vec3(1, 0, 0), 1e-3);
  controller.observe(kMaxForceN, Vec3(1e-3, 0, 0));
  controller.note_applied(Vec3::Zero(), 0.1);
  controller.observe(kMaxForceN, Vec3::Zero());
  EXPECT_DOUBLE_EQ(controller.given_j(), 1e-3);
}

TEST(PassivityController, NoiseOfTheEncoderIsNoDissipation) {
  PassivityController noisy({.mass_kg = kMassKg, .damping_ns_per_m = 1.0, .friction_n = 0.1});
  for (int n = 0; n < 8000; ++n) {
    noisy.note_applied(Vec3(0, 1, 0), 1e-3);
    noisy.observe(kMaxForceN, Vec3(n % 2 == 0 ? 3e-5 : -3e-5, 0, 0));
  }
  EXPECT_NEAR(noisy.given_j(), 0.0, 1e-18);
}

TEST(PassivityController, WhatARoundedPositionMayHideIsNoCredit) {
  PassivityController controller({.mass_kg = kMassKg, .position_step_m = 4e-5});
  controller.note_applied(Vec3(2, 0, 0), 1e-3);
  controller.observe(kMaxForceN, Vec3(-1e-3, 0, 0));
  EXPECT_DOUBLE_EQ(controller.given_j(), -2e-3 + 2.0 * 2e-5);
  controller.note_applied(Vec3(1, 0, 0), 1e-3);
  controller.observe(kMaxForceN, Vec3::Zero());
  EXPECT_DOUBLE_EQ(controller.given_j(), -2e-3 + 3.0 * 2e-5);
}

TEST(PassivityController, WhatTheDeviceDissipatesIsCredit) {
  PassivityController controller({.mass_kg = kMassKg, .damping_ns_per_m = 0.5, .friction_n = 0.1});
  for (int n = 0; n < PassivityController::kWindow; ++n) {
    controller.note_applied(Vec3(0, 1, 0), 1e-3);
    controller.observe(kMaxForceN, Vec3(1e-4, 0, 0));
  }
  const double moved = 1e-4 * PassivityController::kWindow;
  EXPECT_NEAR(controller.given_j(), -(0.5 * 0.1 + 0.1) * moved, 1e-15);
}

TEST(PassivityController, CreditIsBounded) {
  PassivityController controller({.mass_kg = kMassKg});
  for (int n = 0; n < 1000; ++n) {
    controller.note_applied(Vec3(10, 0, 0), 1e-3);
    controller.observe(kMaxForceN, Vec3(-1e-3, 0, 0));
  }
  EXPECT_DOUBLE_EQ(controller.given_j(), -PassivityController::kMaxCreditM * kMaxForceN);
}

// Energy that the force gives a mass that moves away until the next sample: force times (velocity times period, plus what the force adds).
TEST(PassivityController, AForceGetsTheWholeCreditAndInADeficitNothing) {
  constexpr double kCreditPeriodS = 1e-3;
  PassivityController controller({.mass_kg = kMassKg});
  const auto sample = [&](double force_n, double moved_m) {
    controller.note_applied(Vec3(force_n, 0, 0), kCreditPeriodS);
    controller.observe(kMaxForceN, Vec3(moved_m, 0, 0));
  };
  sample(1.0, -1e-3);
  for (const double moved_m : {1e-4, -1e-4, 2e-5}) {
    sample(0.1, moved_m);
    const double credit_j = -controller.given_j();
    ASSERT_GT(credit_j, 0.0);
    const double force_n = controller.shape(Vec3(1000.0, 0, 0), 0.0).x();
    const double gained_m = std::max(0.0, 0.5 * kCreditPeriodS * kCreditPeriodS * 0.1 / kMassKg);
    const double given_j = force_n * (moved_m + gained_m + 0.5 * force_n * kCreditPeriodS * kCreditPeriodS / kMassKg);
    EXPECT_NEAR(given_j, credit_j, 1e-12) << moved_m;
  }
  sample(2.0, 2e-3);
  ASSERT_GT(controller.given_j(), 0.0);
  EXPECT_EQ(controller.shape(Vec3(3, 0, 0), 0.0), Vec3(0, 0, 0)) << "neither given nor reversed";
  EXPECT_TRUE(controller.has_limited());
  EXPECT_GT(controller.shape(Vec3(-3, 0, 0), 0.0).dot(Vec3(-1, 0, 0)), 2.0) << "a force against the motion takes energy back";
}

TEST(PassivityController, BeforeTheFirstSampleNothingIsLimited) {
  PassivityController controller({.mass_kg = kMassKg});
  EXPECT_EQ(controller.shape(Vec3(1, 2, 3), 20.0), Vec3(1, 2, 3));
}

}  // namespace
}  // namespace hapton
