#include "closed_loop/touch_wall.h"

#include <gtest/gtest.h>

#include <cmath>

#include "closed_loop/loop_simulation.h"
#include "closed_loop/press.h"

namespace hapton {
namespace {

PressMeasures press_on(ForceLaw& law) {
  ForceChain chain(law, {});
  const HandModel hand = *find_hand_preset("stylus");
  const PressPath path = make_press_path(hand, {});
  LoopSimulation simulation(
      chain, {.device = {.mass_kg = 0.075, .damping_ns_per_m = 1.0}, .hand = hand, .axes = 3, .path = path.path, .start_m = path.start_m});
  std::vector<LoopRow> rows;
  EXPECT_TRUE(simulation.run_until(path.end_ns, &rows));
  return measure_press(rows, path, 1'000'000, 0.0, true);
}

// On a plate, the step that the haptics node runs on a mesh acts as the wall of theory, except for its contact offset.
TEST(TouchWall, IsTheWallOfTheory) {
  const auto touch = make_touch_wall(1000.0, 0.0);
  ASSERT_TRUE(touch) << touch.error().what;
  WallLaw wall({.stiffness_n_per_m = 1000.0});
  const PressMeasures on_mesh = press_on(**touch);
  const PressMeasures on_wall = press_on(wall);
  EXPECT_NEAR(on_mesh.depth_m, on_wall.depth_m, 0.01 * on_wall.depth_m);
  EXPECT_NEAR(on_mesh.generated_j, on_wall.generated_j, 0.03 * std::fabs(on_wall.generated_j));
  EXPECT_NEAR(on_mesh.overshoot, on_wall.overshoot, 0.02);
}

}  // namespace
}  // namespace hapton
