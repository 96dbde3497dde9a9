// A virtual mass and a viscosity in the closed loop: the limits that find_stable_mass and find_stable_viscosity give, compared with
// simulations of the effects, stepped as the haptics node steps them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "closed_loop/loop_simulation.h"
#include "closed_loop/stability.h"
#include "core/effects/effect_step.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

class EffectLaw final : public ForceLaw {
 public:
  explicit EffectLaw(const SpaceEffect& effect) : step_({}, {effect}) {}
  Vec3 step(const Vec3& p_WD, double dt_s) noexcept override { return step_.step(p_WD, dt_s, {.p_SP = p_WD}).force_n; }
  void reset(const Vec3&) noexcept override { step_.reset(); }

 private:
  EffectStep step_;
};

struct EffectLoop {
  DeviceModel device;
  HandModel hand;
  double delay_ms = 0.0;
  std::int64_t period_ns = kMs;
};

SampledPlant plant_of(const EffectLoop& loop) {
  return SampledPlant(make_axis_plant(loop.device, loop.hand), 1e-9 * static_cast<double>(loop.period_ns), 1e-3 * loop.delay_ms);
}

// Whether, after a push of 10 ms, the largest force of the effect in the interval from 4 to 6 s is above that from 2 to 4 s.
bool effect_loop_grows(const EffectLoop& loop, const SpaceEffect& effect) {
  EffectLaw law(effect);
  ForceChain::Options link;
  link.to_law.delay_ns = static_cast<std::int64_t>(0.5e6 * loop.delay_ms);
  link.from_law.delay_ns = static_cast<std::int64_t>(1e6 * loop.delay_ms) - link.to_law.delay_ns;
  ForceChain chain(law, link);
  DeviceModel device = loop.device;
  device.friction_n = 0.0;
  const HandPath push(std::vector<HandPath::Point>{{.time_ns = 0, .push_n = Vec3(1e-3, 0, 0)}, {.time_ns = 10 * kMs}});
  LoopSimulation simulation(chain, {.device = device, .hand = loop.hand, .period_ns = loop.period_ns, .path = push});
  const auto largest_force_until = [&](std::int64_t end_ns) {
    std::vector<LoopRow> rows;
    if (!simulation.run_until(end_ns, &rows)) return HUGE_VAL;
    double largest_n = 0.0;
    for (const LoopRow& row : rows) largest_n = std::max(largest_n, std::fabs(row.force_n.x()));
    return largest_n;
  };
  largest_force_until(2 * kSecond);
  const double before_n = largest_force_until(4 * kSecond);
  const double after_n = largest_force_until(6 * kSecond);
  EXPECT_GT(before_n, 0.0);
  return after_n > before_n || !std::isfinite(after_n);
}

TEST(StableMass, IsWhereTheEffectItselfBeginsToGrow) {
  constexpr double kNoBound = 1e300;
  for (const char* name : {"model-a", "touch", "omega.3", "wooden"}) {
    for (const char* hand : {"off", "light", "firm"}) {
      for (const double delay_ms : {0.0, 1.4, 10.0}) {
        const EffectLoop loop{.device = find_device_preset(name)->model, .hand = *find_hand_preset(hand), .delay_ms = delay_ms};
        for (const double filter_s : {0.005, 0.05}) {
          const double limit_kg = find_stable_mass(plant_of(loop), filter_s).value;
          SCOPED_TRACE(::testing::Message() << name << " in hand " << hand << ", " << delay_ms << " ms, filter " << filter_s
                                            << " s: " << limit_kg);
          ASSERT_TRUE(std::isfinite(limit_kg));
          EXPECT_FALSE(effect_loop_grows(loop, MassEffect{.mass_kg = 0.97 * limit_kg, .filter_s = filter_s, .max_force_n = kNoBound}));
          EXPECT_TRUE(effect_loop_grows(loop, MassEffect{.mass_kg = 1.03 * limit_kg, .filter_s = filter_s, .max_force_n = kNoBound}));
        }
      }
    }
  }
}

TEST(StableViscosity, IsWhereTheEffectItselfBeginsToGrow) {
  constexpr double kNoBound = 1e300;
  for (const char* name : {"model-a", "touch", "omega.3", "wooden"}) {
    for (const char* hand : {"off", "light", "firm"}) {
      for (const double delay_ms : {0.0, 1.4, 10.0}) {
        const EffectLoop loop{.device = find_device_preset(name)->model, .hand = *find_hand_preset(hand), .delay_ms = delay_ms};
        const double limit = find_stable_viscosity(plant_of(loop)).value;
        SCOPED_TRACE(::testing::Message() << name << " in hand " << hand << ", " << delay_ms << " ms: " << limit << " Ns/m");
        ASSERT_TRUE(std::isfinite(limit));
        if (delay_ms == 0.0) {
          EXPECT_LT(limit, find_stable_damping(plant_of(loop), 0.0).value) << "its velocity lags more";
        }
        EXPECT_FALSE(effect_loop_grows(loop, ViscousEffect{.damping_ns_per_m = 0.97 * limit, .max_force_n = kNoBound}));
        EXPECT_TRUE(effect_loop_grows(loop, ViscousEffect{.damping_ns_per_m = 1.03 * limit, .max_force_n = kNoBound}));
      }
    }
  }
}

// As docs/effects.md says, twice the default mass is stable on every preset device, in every preset hand, with forces up to 5 ms late, at
// 1 kHz and faster.
TEST(StableMass, TheDefaultHasAGainMarginOfTwoOnEveryDevice) {
  for (const DevicePreset& device : device_presets()) {
    for (const HandPreset& hand : hand_presets()) {
      for (const double rate_hz : {1000.0, 4000.0, 10'000.0}) {
        for (double delay_ms = 0.0; delay_ms <= 5.0; delay_ms += 0.25) {
          const SampledPlant plant(make_axis_plant(device.model, hand.model), 1.0 / rate_hz, 1e-3 * delay_ms);
          ASSERT_GT(find_stable_mass(plant, MassEffect().filter_s).value, 2.0 * MassEffect().mass_kg)
              << device.name << " in hand " << hand.name << ", " << rate_hz << " Hz, " << delay_ms << " ms";
        }
      }
    }
  }
}

// At any delay of the force, a virtual mass below the mass of a rigid device is stable.
TEST(StableMass, LessThanTheMassOfARigidDeviceIsStableAtAnyDelay) {
  for (const double delay_ms : {0.0, 3.0, 20.0, 100.0, 500.0}) {
    for (const double filter_s : {0.005, 0.02, 0.2}) {
      const SampledPlant plant(make_axis_plant({.mass_kg = 0.1, .damping_ns_per_m = 0.1}, {}), 1e-3, 1e-3 * delay_ms);
      EXPECT_GT(find_stable_mass(plant, filter_s).value, 0.1) << delay_ms << " ms, filter " << filter_s << " s";
    }
  }
}

// A virtual mass above the stable one oscillates, and its force stays within max_force_n.
TEST(StableMass, BeyondItTheForceIsStillBounded) {
  const EffectLoop loop{.device = find_device_preset("touch")->model, .hand = *find_hand_preset("light"), .delay_ms = 10.0};
  EffectLaw law(MassEffect{.mass_kg = 5.0, .filter_s = 0.005, .max_force_n = 2.0});
  ForceChain::Options link;
  link.from_law.delay_ns = 10 * kMs;
  ForceChain chain(law, link);
  const HandPath push(std::vector<HandPath::Point>{{.time_ns = 0, .push_n = Vec3(0.5, 0, 0)}, {.time_ns = 10 * kMs}});
  LoopSimulation simulation(chain, {.device = loop.device, .hand = loop.hand, .path = push});
  std::vector<LoopRow> rows;
  ASSERT_TRUE(simulation.run_until(5 * kSecond, &rows));
  double largest_n = 0.0;
  for (const LoopRow& row : rows) largest_n = std::max(largest_n, row.force_n.norm());
  EXPECT_GT(largest_n, 1.9) << "it swings at its bound";
  EXPECT_LE(largest_n, 2.0 * (1 + 1e-12));
}

}  // namespace
}  // namespace hapton
