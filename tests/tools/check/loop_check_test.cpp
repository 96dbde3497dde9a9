#include "tools/check/loop_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "loop/recommendation.h"
#include "loop/stability.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::vector<NamedLoop> loops_for_check(const std::string& devices, const std::string& hands) {
  LoopFlags flags;
  flags.device = devices;
  flags.hand = hands;
  auto loops = loops_of(flags);
  EXPECT_TRUE(loops);
  return loops ? *loops : std::vector<NamedLoop>();
}

SceneObject object_of(double stiffness_n_per_m) {
  SceneObject object;
  object.name = "lamp";
  object.material.stiffness_n_per_m = stiffness_n_per_m;
  return object;
}

TEST(LoopCheck, TheLeastOfAllDevicesAndHandsCounts) {
  const auto loops = loops_for_check("omega.3,touch", "light,firm");
  const HeldStiffness held = find_held_stiffness(loops, 1000.0, 1e-3);
  ASSERT_TRUE(held.by_device && held.by_loop);
  EXPECT_EQ(held.by_device->device, "touch");
  EXPECT_EQ(held.device_n_per_m, 400.0);
  double least = std::numeric_limits<double>::infinity();
  for (const NamedLoop& loop : loops)
    least =
        std::min(least, recommend_stiffness(loop.device_model, loop.limits, loop.hand_model, 1000.0, 1e-3).stable_n_per_m / kGainMargin);
  EXPECT_EQ(held.safe_n_per_m, least);
}

TEST(LoopCheck, WhatIsHeldExactlyIsNoFinding) {
  const auto loops = loops_for_check("model-a", "light");
  const HeldStiffness held = find_held_stiffness(loops, 1000.0, 1e-3);
  ASSERT_LT(held.safe_n_per_m, held.device_n_per_m);
  EXPECT_TRUE(check_stiffness(object_of(held.safe_n_per_m), held, 1000.0, 1e-3).empty());
  const CheckFindings above = check_stiffness(object_of(1.001 * held.safe_n_per_m), held, 1000.0, 1e-3);
  ASSERT_EQ(above.size(), 1U);
  EXPECT_EQ(above[0].fault, SceneFault::stiffer_than_loop);
  EXPECT_THAT(above[0].what, HasSubstr("model-a in hand light at 1000 Hz with forces after 1 ms"));
  EXPECT_TRUE(check_stiffness(object_of(std::floor(held.safe_n_per_m)), held, 1000.0, 1e-3).empty()) << "the fix holds";
}

TEST(LoopCheck, EffectsCountAsStiffAsTheyAre) {
  const auto loops = loops_for_check("model-a", "light");
  const HeldStiffness held = find_held_stiffness(loops, 1000.0, 1e-3);
  SceneObject layered = object_of(10.0 * held.safe_n_per_m);
  layered.effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 0.5 * held.safe_n_per_m});
  EXPECT_TRUE(check_stiffness(layered, held, 1000.0, 1e-3).empty()) << "layers replace the spring of the material";
  layered.effects.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 1.1 * held.safe_n_per_m});
  const CheckFindings found = check_stiffness(layered, held, 1000.0, 1e-3);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_THAT(found[0].fix, HasSubstr("the stiffness_n_per_m of its layers"));
  const SceneEffect spring{.name = "home", .effect = SpringEffect{.stiffness_n_per_m = 1.1 * held.safe_n_per_m}};
  const CheckFindings sprung = check_stiffness(spring, held, 1000.0, 1e-3);
  ASSERT_EQ(sprung.size(), 1U);
  EXPECT_EQ(sprung[0].object, "effect home");
  EXPECT_TRUE(check_stiffness(SceneEffect{.name = "wind", .effect = ConstantEffect{}}, held, 1000.0, 1e-3).empty());
}

TEST(LoopCheck, AVirtualMassIsHeldToHalfOfWhatIsStable) {
  const auto loops = loops_for_check("omega.3,touch", "off,firm");
  double least_kg = std::numeric_limits<double>::infinity();
  for (const NamedLoop& loop : loops) {
    const SampledPlant plant(make_axis_plant(loop.device_model, loop.hand_model), 1e-3, 2e-3);
    least_kg = std::min(least_kg, find_stable_mass(plant, 0.03).value / kGainMargin);
  }
  const auto mass_of = [](double mass_kg) {
    return SceneEffect{.name = "lead", .effect = MassEffect{.mass_kg = mass_kg, .filter_s = 0.03}};
  };
  EXPECT_TRUE(check_mass(mass_of(least_kg), loops, 1000.0, 2e-3).empty());
  const CheckFindings above = check_mass(mass_of(1.01 * least_kg), loops, 1000.0, 2e-3);
  ASSERT_EQ(above.size(), 1U);
  EXPECT_EQ(name_of(above[0].fault), "heavier-than-loop");
  EXPECT_EQ(above[0].object, "effect lead");
  EXPECT_THAT(above[0].what, HasSubstr("touch in hand firm at 1000 Hz with forces after 2 ms is safe only up to"));
  EXPECT_TRUE(check_mass({.name = "wind", .effect = ConstantEffect{}}, loops, 1000.0, 2e-3).empty());
}

TEST(LoopCheck, ALoopOfOnesOwnHasNoMaker) {
  LoopFlags flags;
  flags.mass_kg = 0.2;
  flags.damping_ns_per_m = 5.0;
  const auto loops = loops_of(flags);
  ASSERT_TRUE(loops);
  const HeldStiffness held = find_held_stiffness(*loops, 1000.0, 1e-3);
  EXPECT_EQ(held.by_device, nullptr);
  ASSERT_NE(held.by_loop, nullptr);
  EXPECT_EQ(check_stiffness(object_of(1e6), held, 1000.0, 1e-3).size(), 1U);
}

}  // namespace
}  // namespace hapton
