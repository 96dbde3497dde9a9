#include "closed_loop/prescribed_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "closed_loop/passivity.h"

namespace hapton {
namespace {

double passive(const DeviceModel& device, double period_s, double delay_s) {
  return find_passive_stiffness({.period_s = period_s,
                                 .delay_s = delay_s,
                                 .damping_ns_per_m = device.damping_ns_per_m,
                                 .friction_n = device.friction_n,
                                 .encoder_step_m = device.encoder_step_m})
      .least_n_per_m();
}

// Simulation against theory: a wall begins to give energy where Colgate and Schenkel say.
TEST(EnergyOnset, IsColgateAndSchenkelsWithin2Percent) {
  for (const std::int64_t period_ns : {4'000'000, 1'000'000, 100'000}) {
    for (const std::int64_t delay_ns : {0, 300'000, 1'000'000, 20'700'000, 500'000'000}) {
      for (const double damping : {0.005, 1.0, 8.0}) {
        const DeviceModel device{.mass_kg = 0.1, .damping_ns_per_m = damping};
        const double expected = passive(device, 1e-9 * static_cast<double>(period_ns), 1e-9 * static_cast<double>(delay_ns));
        const EnergyOnset onset = find_energy_onset(device, period_ns, delay_ns);
        EXPECT_NEAR(onset.stiffness_n_per_m, expected, 0.02 * expected) << period_ns << " ns, " << delay_ns << " ns, " << damping;
      }
    }
  }
}

// The condition of Abbott and Okamura: K <= min(2b/T, 2 f_c / step), with the Coulomb friction f_c.
TEST(EnergyOnset, WithEncoderStepsAndFrictionIsAbbottAndOkamurasWithin2Percent) {
  int by_friction = 0;
  int by_damping = 0;
  for (const double step_m : {1e-5, 3e-5, 1e-4}) {
    for (const double friction_n : {0.01, 0.04, 0.26}) {
      for (const double damping : {0.1, 1.0, 5.0}) {
        const DeviceModel device{.mass_kg = 0.1, .damping_ns_per_m = damping, .friction_n = friction_n, .encoder_step_m = step_m};
        const double expected = std::min(2e3 * damping, 2.0 * friction_n / step_m);
        EXPECT_NEAR(passive(device, 1e-3, 0.0), expected, 1e-6 * expected);
        const EnergyOnset onset = find_energy_onset(device, 1'000'000, 0);
        EXPECT_NEAR(onset.stiffness_n_per_m, expected, 0.02 * expected) << step_m << " m, " << friction_n << " N, " << damping;
        (onset.motion == "press and release" ? by_damping : by_friction) += 1;
      }
    }
  }
  EXPECT_GT(by_friction, 3);
  EXPECT_GT(by_damping, 3);
}

TEST(EnergyOnset, EncoderStepsStayTheLimitWithDelay) {
  const DeviceModel device{.mass_kg = 0.1, .damping_ns_per_m = 20.0, .friction_n = 0.02, .encoder_step_m = 3e-5};
  const EnergyOnset onset = find_energy_onset(device, 1'000'000, 3'000'000);
  EXPECT_NEAR(onset.stiffness_n_per_m, passive(device, 1e-3, 3e-3), 0.02 * onset.stiffness_n_per_m);
}

// Expected is K e^(-jw delay), times (1 - e^(-jwT)) / jwT of the hold.
TEST(RenderedStiffness, OfASpringHasThePhaseOfHoldAndDelay) {
  const double period_s = 1e-3;
  // The last delay is many periods long: no force arrives in the first ones.
  for (const double delay_s : {0.0, 2.3e-3, 0.5}) {
    for (const double frequency_hz : {3.1, 31.7, 101.3}) {
      WallLaw wall({.stiffness_n_per_m = 800.0, .two_sided = true});
      ForceChain::Options link;
      link.to_law.delay_ns = static_cast<std::int64_t>(1e9 * delay_s);
      ForceChain chain(wall, link);
      const std::complex<double> measured =
          measure_rendered_stiffness(chain, 1'000'000, frequency_hz, 0.0, 1e-3, link.to_law.delay_ns, 200);
      const std::complex<double> s(0.0, 2.0 * std::numbers::pi * frequency_hz);
      const std::complex<double> expected = 800.0 * std::exp(-s * delay_s) * (1.0 - std::exp(-s * period_s)) / (s * period_s);
      EXPECT_LT(std::abs(measured - expected), 0.005 * 800.0) << frequency_hz << " Hz: " << measured << " " << expected;
    }
  }
}

}  // namespace
}  // namespace hapton
