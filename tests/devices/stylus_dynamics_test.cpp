#include "devices/stylus_dynamics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>
#include <random>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr AxisStops kNoStops{-1e6, 1e6};

// Device mass and stylus are not connected: the motion of each then has its own closed form.
StylusModel unconnected_model() {
  StylusModel model;
  model.structure_hz = 0.0;
  model.friction_n = 0.0;
  return model;
}

TEST(StylusDynamics, FreeMassWithDamperApproachesItsFinalSpeed) {
  StylusModel model = unconnected_model();
  model.device_damping_n_s_per_m = 0.5;
  const StylusDynamics dynamics(model);
  AxisState state;
  const double force = 2.0, b = 0.5, m = model.device_mass_kg;
  for (std::int64_t now = 0; now < 500 * kMs; now += kMs) {
    dynamics.advance(state, {force, 0.0, 0.0}, kNoStops, now, kMs);
    const double t = 1e-9 * static_cast<double>(now + kMs);
    const double decay = std::exp(-b / m * t);
    ASSERT_NEAR(state.device_m_per_s, force / b * (1.0 - decay), 1e-9);
    ASSERT_NEAR(state.device_m, force / b * (t - m / b * (1.0 - decay)), 1e-9);
  }
}

TEST(StylusDynamics, HandFollowsAStepOfItsIntentionAsAMassSpringDamper) {
  const StylusModel model = unconnected_model();
  const StylusDynamics dynamics(model);
  const double mass = model.stylus_mass_kg + model.hand_mass_kg;
  const double omega = std::sqrt(model.hand_stiffness_n_per_m / mass);
  const double zeta = model.hand_damping_n_s_per_m / (2.0 * mass * omega);
  const double damped = omega * std::sqrt(1.0 - zeta * zeta);
  AxisState state;
  for (std::int64_t now = 0; now < 1000 * kMs; now += 4 * kMs) {
    dynamics.advance(state, {0.0, 0.01, 0.0}, kNoStops, now, 4 * kMs);
    const double t = 1e-9 * static_cast<double>(now + 4 * kMs);
    const double remaining = std::exp(-zeta * omega * t) * (std::cos(damped * t) + zeta * omega / damped * std::sin(damped * t));
    ASSERT_NEAR(state.stylus_m, 0.01 * (1.0 - remaining), 1e-12);
  }
}

TEST(StylusDynamics, HandFollowsARampWithoutDelayAtTheEnd) {
  const StylusDynamics dynamics(unconnected_model());
  AxisState state;
  for (std::int64_t now = 0; now < 3000 * kMs; now += kMs) {
    dynamics.advance(state, {0.0, 0.1 * 1e-9 * static_cast<double>(now), 0.1}, kNoStops, now, kMs);
  }
  EXPECT_NEAR(state.stylus_m, 0.3, 1e-9);
  EXPECT_NEAR(state.stylus_m_per_s, 0.1, 1e-9);
}

// Position per force of the whole chain at s = j omega.
std::complex<double> response(const StylusModel& model, double omega) {
  const std::complex<double> s(0.0, omega);
  const double k_s = model.structure_stiffness_n_per_m(), b_s = model.structure_damping_n_s_per_m();
  const std::complex<double> bridge = b_s * s + k_s;
  const std::complex<double> hand =
      (model.stylus_mass_kg + model.hand_mass_kg) * s * s + model.hand_damping_n_s_per_m * s + model.hand_stiffness_n_per_m;
  const std::complex<double> device = model.device_mass_kg * s * s + model.device_damping_n_s_per_m * s;
  return 1.0 / (device + bridge * hand / (bridge + hand));
}

TEST(StylusDynamics, SinusoidalForceGivesTheTransferFunctionsAmplitudeAndPhase) {
  StylusModel model;
  model.friction_n = 0.0;
  const StylusDynamics dynamics(model);
  for (const double hz : {1.0, 5.0, 12.5, 25.0, 50.0, 100.0}) {
    const double omega = 2.0 * std::numbers::pi * hz;
    const std::int64_t dt = 50'000;
    const double half_step = 0.5e-9 * static_cast<double>(dt);
    AxisState state;
    std::complex<double> sum = 0.0;
    const auto period = static_cast<std::int64_t>(1e9 / hz);
    const std::int64_t settle = (2000 * kMs / period + 1) * period;
    for (std::int64_t now = 0; now < settle + 10 * period; now += dt) {
      const double middle = 1e-9 * static_cast<double>(now) + half_step;
      dynamics.advance(state, {std::cos(omega * middle), 0.0, 0.0}, kNoStops, now, dt);
      const double t = middle + half_step;
      if (now >= settle) sum += state.device_m * std::polar(1.0, -omega * t);
    }
    const std::complex<double> measured = 2.0 * sum / (10.0 * static_cast<double>(period / dt));
    // Holding the force over dt shrinks its fundamental by a sinc.
    const std::complex<double> expected = response(model, omega) * std::sin(omega * half_step) / (omega * half_step);
    EXPECT_LT(std::abs(measured - expected), 1e-3 * std::abs(expected)) << hz << " Hz";
  }
}

// The memo: "constrained, small amplitude mechanical bandwidth ... 30 Hz". With the stylus held the device mass rings at 30 Hz.
TEST(StylusDynamics, HeldStylusLeavesAModeOfThirtyHertz) {
  StylusModel model;
  model.friction_n = 0.0;
  model.device_damping_n_s_per_m = 0.0;
  model.structure_damping_ratio = 0.01;
  model.hand_mass_kg = 1e6;
  const StylusDynamics dynamics(model);
  AxisState state;
  int crossings = 0;
  double previous = 1.0;
  for (std::int64_t now = 0; now < 1000 * kMs; now += kMs / 10) {
    dynamics.advance(state, {1.0, 0.0, 0.0}, kNoStops, now, kMs / 10);
    const double off_centre = state.device_m - 1.0 / model.structure_stiffness_n_per_m();
    crossings += off_centre * previous < 0.0 ? 1 : 0;
    previous = off_centre;
  }
  EXPECT_NEAR(crossings, 60, 1);
}

TEST(StylusDynamics, CoulombFrictionStopsACoastingMassWhereItShouldAndHoldsIt) {
  StylusModel model = unconnected_model();
  model.friction_n = 0.04;
  model.device_damping_n_s_per_m = 0.0;
  const StylusDynamics dynamics(model);
  AxisState state{0.0, 0.1, 0.0, 0.0};
  const double stop_s = model.device_mass_kg * 0.1 / model.friction_n;
  for (std::int64_t now = 0; now < 400 * kMs; now += kMs) dynamics.advance(state, {}, kNoStops, now, kMs);
  ASSERT_LT(stop_s, 0.4);
  EXPECT_EQ(state.device_m_per_s, 0.0);
  EXPECT_NEAR(state.device_m, 0.5 * 0.1 * stop_s, 1e-9);
  const double stopped_m = state.device_m;
  for (std::int64_t now = 400 * kMs; now < 600 * kMs; now += kMs) dynamics.advance(state, {-0.039, 0.0, 0.0}, kNoStops, now, kMs);
  EXPECT_EQ(state.device_m, stopped_m);
  dynamics.advance(state, {-0.06, 0.0, 0.0}, kNoStops, 600 * kMs, 10 * kMs);
  EXPECT_NEAR(state.device_m - stopped_m, -0.5 * 0.02 / model.device_mass_kg * 1e-4, 1e-10);
}

TEST(StylusDynamics, FrictionHoldsExactlyAgainstAForceEitherWay) {
  StylusModel model = unconnected_model();
  model.friction_n = 0.04;
  const StylusDynamics dynamics(model);
  for (const double force_n : {0.03, -0.03}) {
    AxisState state;
    for (std::int64_t now = 0; now < 100 * kMs; now += kMs) dynamics.advance(state, {force_n, 0.0, 0.0}, kNoStops, now, kMs);
    EXPECT_EQ(state.device_m, 0.0) << force_n;
    EXPECT_EQ(state.device_m_per_s, 0.0) << force_n;
  }
}

TEST(StylusDynamics, StopIsHardAndReleases) {
  StylusModel model = unconnected_model();
  model.device_damping_n_s_per_m = 0.0;
  const StylusDynamics dynamics(model);
  for (const double side : {1.0, -1.0}) {
    AxisState state{0.0, side * 0.5, 0.0, 0.0};
    dynamics.advance(state, {side * 3.0, 0.0, 0.0}, {-0.01, 0.01}, 0, 200 * kMs);
    EXPECT_EQ(state.device_m, side * 0.01);
    EXPECT_EQ(state.device_m_per_s, 0.0);
    dynamics.advance(state, {side * -0.07, 0.0, 0.0}, {-0.01, 0.01}, 200 * kMs, 100 * kMs);
    EXPECT_NEAR(state.device_m, side * (0.01 - 0.5 * 0.07 / model.device_mass_kg * 0.01), 1e-9);
  }
}

TEST(StylusDynamics, ResultDoesNotDependOnTheStep) {
  const StylusDynamics dynamics{StylusModel{}};
  const AxisStops stops{-0.02, 0.02};
  const auto input_at = [](std::int64_t ms) {
    std::mt19937_64 random(static_cast<std::uint64_t>(ms / 4 + 17));
    const auto draw = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0; };
    return AxisInput{6.0 * draw(), 0.03 * draw(), 0.2 * draw()};
  };
  const auto run = [&](std::int64_t dt) {
    AxisState state;
    for (std::int64_t now = 0; now < 2000 * kMs; now += dt) {
      const std::int64_t block = now / (4 * kMs) * (4 * kMs);
      AxisInput input = input_at(block / kMs);
      input.hand_m += input.hand_m_per_s * 1e-9 * static_cast<double>(now - block);
      dynamics.advance(state, input, stops, now, dt);
    }
    return state;
  };
  const AxisState coarse = run(4 * kMs);
  for (const std::int64_t dt : {100'000L, 125'000L, 250'000L, 500'000L, 1'000'000L, 2'000'000L}) {
    const AxisState fine = run(dt);
    EXPECT_NEAR(fine.device_m, coarse.device_m, 1e-9) << dt;
    EXPECT_NEAR(fine.stylus_m, coarse.stylus_m, 1e-9) << dt;
    EXPECT_NEAR(fine.device_m_per_s, coarse.device_m_per_s, 1e-7) << dt;
  }
}

TEST(StylusDynamics, EnergyNeverGrowsWithoutADrive) {
  const StylusDynamics dynamics{StylusModel{}};
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> draw(-1.0, 1.0);
  for (int run = 0; run < 50; ++run) {
    const double hand = 0.03 * draw(random);
    AxisState state{0.02 * draw(random), draw(random), 0.03 * draw(random), draw(random)};
    double energy = dynamics.energy_j(state, hand);
    const double first = energy;
    for (std::int64_t now = 0; now < 1000 * kMs; now += kMs / 4) {
      dynamics.advance(state, {0.0, hand, 0.0}, {-0.02, 0.02}, now, kMs / 4);
      const double next = dynamics.energy_j(state, hand);
      ASSERT_LE(next, energy + 1e-12 * first) << "run " << run << " at " << now;
      energy = next;
    }
    EXPECT_LT(energy, 0.2 * first);
  }
}

// The brute-force twin integrates the same equations in small steps, without smoothing the friction.
TEST(StylusDynamics, AgreesWithBruteForceIntegration) {
  const StylusModel model;
  const StylusDynamics dynamics(model);
  const double k = model.structure_stiffness_n_per_m(), b = model.structure_damping_n_s_per_m();
  const double mass = model.stylus_mass_kg + model.hand_mass_kg;
  AxisState exact, rough;
  const double h = 1e-7;
  for (int ms = 0; ms < 300; ++ms) {
    const AxisInput input{1.5 * std::sin(0.13 * ms), 0.01 * std::sin(0.05 * ms), 0.0};
    dynamics.advance(exact, input, kNoStops, ms * kMs, kMs);
    for (int n = 0; n < 10'000; ++n) {
      const double bridge = k * (rough.stylus_m - rough.device_m) + b * (rough.stylus_m_per_s - rough.device_m_per_s);
      const double net = input.force_n + bridge - model.device_damping_n_s_per_m * rough.device_m_per_s;
      const double before = rough.device_m_per_s;
      const bool stuck = before == 0.0 && std::abs(net) <= model.friction_n;
      const double sense = before != 0.0 ? before : net;
      double speed = stuck ? 0.0 : before + h * (net - std::copysign(model.friction_n, sense)) / model.device_mass_kg;
      if (before * speed < 0.0) speed = 0.0;
      rough.device_m += h * speed;
      rough.device_m_per_s = speed;
      const double pull =
          -bridge + model.hand_stiffness_n_per_m * (input.hand_m - rough.stylus_m) - model.hand_damping_n_s_per_m * rough.stylus_m_per_s;
      rough.stylus_m_per_s += h * pull / mass;
      rough.stylus_m += h * rough.stylus_m_per_s;
    }
    ASSERT_NEAR(exact.device_m, rough.device_m, 2e-7) << ms;
    ASSERT_NEAR(exact.stylus_m, rough.stylus_m, 2e-7) << ms;
  }
}

}  // namespace
}  // namespace hapton
