#include "closed_loop/axis_motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(AxisMotion, AMassOnASpringSwingsAsTheFormulaSays) {
  const AxisMotion motion({.mass_kg = 0.5}, {.stiffness_n_per_m = 200.0});
  AxisMotion::State state = motion.rest_at(0.01);
  const double omega = 20.0;
  for (int ms = 1; ms <= 1000; ++ms) {
    motion.advance(state, {}, kMs);
    EXPECT_NEAR(state.position_m(), 0.01 * std::cos(omega * 1e-3 * ms), 1e-10);
    EXPECT_NEAR(state.velocity_m_per_s(), -0.01 * omega * std::sin(omega * 1e-3 * ms), 1e-8);
  }
}

TEST(AxisMotion, StopsWhereTheFormulaOfCoulombFrictionSays) {
  // From 9.5 mm, with friction that holds within 2 mm: half swings about 2 mm and -2 mm turn at -5.5 mm and at 1.5 mm, where it sticks.
  const AxisMotion motion({.mass_kg = 0.5, .friction_n = 0.4}, {.stiffness_n_per_m = 200.0});
  AxisMotion::State state = motion.rest_at(0.0095);
  const double half_period_ns = 1e9 * std::acos(-1.0) / 20.0;
  motion.advance(state, {}, static_cast<std::int64_t>(half_period_ns));
  EXPECT_NEAR(state.position_m(), -0.0055, 1e-9);
  motion.advance(state, {}, static_cast<std::int64_t>(half_period_ns) + kMs);
  EXPECT_NEAR(state.position_m(), 0.0015, 1e-9);
  EXPECT_EQ(state.velocity_m_per_s(), 0.0);
  EXPECT_NEAR(state.lost_j, 0.4 * (0.015 + 0.007), 1e-8);
  motion.advance(state, {}, 500 * kMs);
  EXPECT_NEAR(state.position_m(), 0.0015, 1e-9);
}

TEST(AxisMotion, BreaksAwayWhenTheForceExceedsFriction) {
  const AxisMotion motion({.mass_kg = 0.5, .friction_n = 0.4}, {.stiffness_n_per_m = 200.0});
  AxisMotion::State state = motion.rest_at(0.0);
  // The hand pulls away at 10 mm/s: the spring reaches 0.4 N after 200 ms.
  motion.advance(state, {.hand_m_per_s = 0.01}, 199 * kMs);
  EXPECT_EQ(state.position_m(), 0.0);
  motion.advance(state, {.hand_m = 0.00199, .hand_m_per_s = 0.01}, 20 * kMs);
  EXPECT_GT(state.position_m(), 0.0);
}

// For every device, in one hand at rest: the work of the motor is stored in device and hand, or dissipated.
TEST(AxisMotion, EnergyBalances) {
  for (const DevicePreset& preset : device_presets()) {
    for (const double amplifier_hz : {0.0, 300.0}) {
      DeviceModel device = preset.model;
      // With the amplifier the device has two joints, without it those of the preset.
      if (amplifier_hz > 0.0) {
        device.mode_count = 2;
        device.modes[0] = {0.3 * device.mass_kg, 3000.0, 1.0};
        device.modes[1] = {0.2 * device.mass_kg, 9000.0, 0.5};
      }
      device.amplifier_hz = amplifier_hz;
      const HandModel hand{0.15, 0.0, 500.0};
      const AxisMotion motion(device, hand);
      AxisMotion::State state = motion.rest_at(0.0);
      for (int ms = 0; ms < 300; ++ms) motion.advance(state, {.command_n = 2.0 * std::sin(0.05 * ms)}, kMs);
      EXPECT_GT(state.lost_j, 0.0);
      EXPECT_NEAR(state.motor_j - state.lost_j, motion.stored_j(state, 0.0), 1e-6 * std::fabs(state.motor_j) + 1e-12) << preset.name;
    }
  }
}

TEST(AxisMotion, DoesNotDependOnHowAnIntervalIsCut) {
  const AxisMotion motion(find_device_preset("touch")->model, *find_hand_preset("stylus"));
  AxisMotion::State whole = motion.rest_at(0.0);
  AxisMotion::State cut = whole;
  motion.advance(whole, {.command_n = 1.0}, 50 * kMs);
  for (int i = 0; i < 500; ++i) motion.advance(cut, {.command_n = 1.0}, kMs / 10);
  EXPECT_NEAR(whole.position_m(), cut.position_m(), 1e-9);
}

}  // namespace
}  // namespace hapton
