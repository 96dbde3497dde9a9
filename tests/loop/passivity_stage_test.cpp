#include "loop/passivity_stage.h"

#include <gtest/gtest.h>

#include "loop/loop_simulation.h"
#include "loop/press.h"

namespace hapton {
namespace {

struct Outcome {
  PressMeasures press;
  double worst_debt_j = 0.0;
};

Outcome press(const DevicePreset& device, const HandModel& hand, double stiffness, std::int64_t delay_ns, bool is_controlled) {
  PassivityStage stage({.observer = {}, .most_damping_ns_per_m = 250.0 * device.model.mass_kg});
  WallLaw wall({.stiffness_n_per_m = stiffness});
  ForceChain::Options link{.encoder_step_m = device.model.encoder_step_m, .max_force_n = device.model.max_force_n};
  link.there.delay_ns = delay_ns;
  link.stage = is_controlled ? &stage : nullptr;
  ForceChain chain(wall, link);
  const PressPath path = make_press_path(hand, {.wall_n_per_m = stiffness});
  LoopSimulation simulation(chain, {.device = device.model, .hand = hand, .path = path.path, .start_m = path.start_m});
  std::vector<LoopRow> rows;
  const bool is_bounded = simulation.run_until(path.end_ns, &rows);
  return {measure_press(rows, path, 1'000'000, device.model.encoder_step_m, is_bounded), stage.controller().worst_debt_j()};
}

// A press that feeds energy to the hand without the controller does not with it.
TEST(PassivityStage, TakesTheEnergyOutOfADelayedWall) {
  const HandModel hand = *find_hand_preset("stylus");
  for (const DevicePreset& device : device_presets()) {
    for (const std::int64_t delay_ns : {5'000'000, 20'000'000, 100'000'000}) {
      const Outcome without = press(device, hand, 3000.0, delay_ns, false);
      const Outcome with = press(device, hand, 3000.0, delay_ns, true);
      EXPECT_TRUE(with.press.is_bounded) << device.name;
      EXPECT_GT(without.press.wall_j, 1e-3) << device.name << ", " << delay_ns;
      EXPECT_LT(with.press.generated_j, 0.0) << device.name << ", " << delay_ns;
      EXPECT_LT(with.press.wall_j, 0.1 * without.press.wall_j) << device.name << ", " << delay_ns;
    }
  }
}

TEST(PassivityStage, LeavesAPassiveWallAlmostAlone) {
  const DevicePreset& device = *find_device_preset("falcon");
  const HandModel hand = *find_hand_preset("firm");
  const Outcome without = press(device, hand, 500.0, 0, false);
  const Outcome with = press(device, hand, 500.0, 0, true);
  EXPECT_NEAR(with.press.depth_m, without.press.depth_m, 0.05 * without.press.depth_m);
}

}  // namespace
}  // namespace hapton
