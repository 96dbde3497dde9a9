#include "closed_loop/passivity_stage.h"

#include <gtest/gtest.h>

#include "closed_loop/loop_simulation.h"
#include "closed_loop/press.h"
#include "closed_loop/zwidth.h"
#include "core/force/virtual_coupling.h"

namespace hapton {
namespace {

struct Outcome {
  PressMeasures press;
  double worst_debt_j = 0.0;
};

Outcome press(const DevicePreset& device, const HandModel& hand, double stiffness, const LinkFaults& each_way, bool is_controlled) {
  PassivityStage stage({.device = {.mass_kg = device.model.mass_kg, .position_step_m = device.model.encoder_step_m},
                        .most_damping_ns_per_m = 250.0 * device.model.mass_kg,
                        .max_force_n = device.model.max_force_n});
  WallLaw wall({.stiffness_n_per_m = stiffness});
  ForceChain chain(wall, {.encoder_step_m = device.model.encoder_step_m,
                          .max_force_n = device.model.max_force_n,
                          .to_law = each_way,
                          .from_law = each_way,
                          .seed = 5,
                          .stage = is_controlled ? &stage : nullptr});
  const PressPath path = make_press_path(hand, {.wall_n_per_m = stiffness});
  LoopSimulation simulation(chain, {.device = device.model, .hand = hand, .path = path.path, .start_m = path.start_m});
  std::vector<LoopRow> rows;
  const bool is_bounded = simulation.run_until(path.end_ns, &rows);
  return {measure_press(rows, path, 1'000'000, device.model.encoder_step_m, is_bounded), stage.worst_debt_j()};
}

// A wall of 100 N/mm, delays up to 500 ms, without faults or with 30 % loss and 20 ms jitter each way: with the controller every device in
// every hand stays bounded, and the hand has drawn no energy at any time.
TEST(PassivityStage, NoPresetDrawsEnergyFrom100NPerMmAcrossABadLink) {
  int unsafe_without = 0;
  int presses = 0;
  for (const DevicePreset& device : device_presets()) {
    for (const HandPreset& hand : hand_presets()) {
      for (const std::int64_t delay_ms : {0, 5, 50, 200, 500}) {
        for (const bool is_bad : {false, true}) {
          const LinkFaults each_way{.delay_ns = delay_ms * 500'000, .jitter_ns = is_bad ? 20'000'000 : 0, .loss = is_bad ? 0.3 : 0.0};
          SCOPED_TRACE(::testing::Message() << device.name << ", " << hand.name << ", " << delay_ms << " ms" << (is_bad ? ", bad" : ""));
          const Outcome with = press(device, hand.model, 1e5, each_way, true);
          EXPECT_TRUE(with.press.is_bounded);
          EXPECT_LT(with.press.generated_j, 0.0);
          EXPECT_LT(with.press.most_generated_j, 1e-9);
          unsafe_without += press(device, hand.model, 1e5, each_way, false).press.generated_j > 0.0 ? 1 : 0;
          ++presses;
        }
      }
    }
  }
  EXPECT_GT(unsafe_without, presses / 2);
}

// Without the controller the delayed wall gives energy. With it the hand gets none, and the wall gives less than a tenth.
TEST(PassivityStage, TakesTheEnergyOutOfADelayedWall) {
  const HandModel hand = *find_hand_preset("stylus");
  for (const DevicePreset& device : device_presets()) {
    for (const std::int64_t delay_ns : {5'000'000, 20'000'000, 100'000'000}) {
      const Outcome without = press(device, hand, 3000.0, {.delay_ns = delay_ns / 2}, false);
      const Outcome with = press(device, hand, 3000.0, {.delay_ns = delay_ns / 2}, true);
      EXPECT_TRUE(with.press.is_bounded) << device.name;
      EXPECT_GT(without.press.wall_j, 1e-3) << device.name << ", " << delay_ns;
      EXPECT_LT(with.press.generated_j, 0.0) << device.name << ", " << delay_ns;
      EXPECT_LT(with.press.wall_j, 0.1 * without.press.wall_j) << device.name << ", " << delay_ns;
    }
  }
}

// Coupled through a spring as stiff as the limit of passivity of the device, even the stiffest wall is safe in every hand.
TEST(VirtualCouplingInTheLoop, AtTheLimitOfPassivityNoHandDrawsEnergyFromAnyWall) {
  int unsafe_without = 0;
  for (const DevicePreset& device : device_presets()) {
    for (const std::int64_t delay_ns : {0, 1'000'000, 5'000'000}) {
      const double passive =
          find_zwidth({.device = device.model, .hand = {}, .delay_s = 1e-9 * static_cast<double>(delay_ns)}).passive.least_n_per_m();
      ASSERT_GT(passive, 0.0) << device.name;
      for (const HandPreset& hand : hand_presets()) {
        for (const double wall : {1e3, 1e4, 1e5, 1e6}) {
          const double coupled = couple_material({.stiffness_n_per_m = wall}, passive).stiffness_n_per_m;
          const Outcome with = press(device, hand.model, coupled, {.delay_ns = delay_ns / 2}, false);
          EXPECT_TRUE(with.press.is_bounded) << device.name << ", " << hand.name << ", " << wall;
          EXPECT_LE(with.press.generated_j, 0.0) << device.name << ", " << hand.name << ", " << delay_ns << ", " << wall;
          unsafe_without += press(device, hand.model, wall, {.delay_ns = delay_ns / 2}, false).press.generated_j > 0.0 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_GT(unsafe_without, 20);
}

TEST(PassivityStage, LeavesAPassiveWallAlmostAlone) {
  const DevicePreset& device = *find_device_preset("falcon");
  const HandModel hand = *find_hand_preset("firm");
  const Outcome without = press(device, hand, 500.0, {}, false);
  const Outcome with = press(device, hand, 500.0, {}, true);
  EXPECT_NEAR(with.press.depth_m, without.press.depth_m, 0.05 * without.press.depth_m);
}

}  // namespace
}  // namespace hapton
