#include "core/effects/tissue_layers.h"

#include <gtest/gtest.h>

#include <random>

namespace hapton {
namespace {

// Skin, an organ and bone.
TissueLayers made_layers() {
  TissueLayers layers;
  layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400, .pop_force_n = 1.0, .drag_ns_per_m = 0});
  layers.add({.depth_m = 0.010, .stiffness_n_per_m = 800, .pop_force_n = 2.0, .drag_ns_per_m = 5});
  layers.add({.depth_m = 0.020, .stiffness_n_per_m = 2000});
  return layers;
}

TEST(TissueLayers, ResistLikeASpringUntilTheyArePunctured) {
  const TissueLayers layers = made_layers();
  TissueLayers::State state;
  EXPECT_DOUBLE_EQ(layers.force(0.001, 0, state), 0.4);
  EXPECT_DOUBLE_EQ(layers.force(0.0025, 0, state), 1.0) << "at the pop-through force it still holds";
  EXPECT_EQ(layers.force(0.0026, 0, state), 0.0) << "punctured";
  EXPECT_EQ(state.punctured_count, 1U);
  EXPECT_EQ(layers.force(0.009, 0, state), 0.0) << "between two layers";
  EXPECT_DOUBLE_EQ(layers.force(0.012, 0, state), 1.6);
  EXPECT_EQ(layers.force(0.0126, 0, state), 0.0) << "punctured";
  EXPECT_DOUBLE_EQ(layers.force(0.021, 0, state), 2.0);
  EXPECT_EQ(layers.force(0.5, 0, state), kMaxEffectForceN) << "bone is never punctured";
  EXPECT_EQ(state.punctured_count, 2U);
}

TEST(TissueLayers, DragTheNeedleBothWaysOncePunctured) {
  const TissueLayers layers = made_layers();
  TissueLayers::State state;
  EXPECT_DOUBLE_EQ(layers.force(0.002, 0.1, state), 0.8) << "no drag before the first puncture";
  layers.force(0.003, 0, state);
  layers.force(0.013, 0, state);
  EXPECT_DOUBLE_EQ(layers.force(0.015, 0.1, state), 0.5);
  EXPECT_DOUBLE_EQ(layers.force(0.015, -0.1, state), -0.5);
  EXPECT_EQ(layers.force(0.015, -1e6, state), -kMaxEffectForceN);
}

TEST(TissueLayers, ANeedleDrawnBackMeetsNoSpring) {
  const TissueLayers layers = made_layers();
  TissueLayers::State state;
  layers.force(0.0126, 0, state);
  for (double depth = 0.0126; depth > 0.0; depth -= 0.0005) EXPECT_EQ(layers.force(depth, 0, state), 0.0) << depth;
}

// One large step through two layers: neither may give back more energy than the hand has put in.
TEST(TissueLayers, APunctureLeavesNoTension) {
  const TissueLayers layers = made_layers();
  TissueLayers::State state;
  EXPECT_EQ(layers.force(0.016, 0, state), 0.0);
  EXPECT_EQ(state.punctured_count, 1U);
  EXPECT_EQ(state.rest_depth_m, 0.016);
  EXPECT_NEAR(layers.force(0.017, 0, state), 0.8, 1e-12);
  EXPECT_EQ(layers.force(0.015, 0, state), 0.0);
}

// Along any path of depths that begins and ends at zero, with small steps: the work on the hand is never positive.
TEST(TissueLayers, TakeEnergyOverAnyPath) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    const TissueLayers layers = made_layers();
    TissueLayers::State state;
    double depth = 0.0;
    double before_n = 0.0;
    double energy_to_hand_j = 0.0;
    for (int leg = 0; leg < 20; ++leg) {
      const double target = leg == 19 ? 0.0 : 0.022 * unit(random);
      const double step = target > depth ? 1e-6 : -1e-6;
      while (std::abs(target - depth) > 1e-6) {
        depth += step;
        const double force_n = layers.force(depth, 1e3 * step, state);
        energy_to_hand_j -= 0.5 * (before_n + force_n) * step;  // outwards
        before_n = force_n;
      }
    }
    EXPECT_LT(energy_to_hand_j, 1e-9) << "seed " << seed;
  }
}

}  // namespace
}  // namespace hapton
