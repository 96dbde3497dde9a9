#include "tools/check/loop_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "closed_loop/recommendation.h"
#include "closed_loop/stability.h"

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
  const SafeGains gains = find_safe_gains(loops, 1000.0, 1e-3);
  ASSERT_TRUE(gains.by_device && gains.by_loop);
  EXPECT_EQ(gains.by_device->device, "touch");
  EXPECT_EQ(gains.device_n_per_m, 400.0);
  double least_safe_n_per_m = std::numeric_limits<double>::infinity();
  for (const NamedLoop& loop : loops)
    least_safe_n_per_m =
        std::min(least_safe_n_per_m,
                 recommend_stiffness(loop.device_model, loop.limits, loop.hand_model, 1000.0, 1e-3).stable_n_per_m / kGainMargin);
  EXPECT_EQ(gains.safe_n_per_m, least_safe_n_per_m);
}

TEST(LoopCheck, AStiffnessAtItsLimitIsNoFinding) {
  const auto loops = loops_for_check("model-a", "light");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 1e-3);
  ASSERT_LT(gains.safe_n_per_m, gains.device_n_per_m);
  EXPECT_TRUE(check_stiffness(object_of(gains.safe_n_per_m), gains, 1000.0, 1e-3).empty());
  const CheckFindings above = check_stiffness(object_of(1.001 * gains.safe_n_per_m), gains, 1000.0, 1e-3);
  ASSERT_EQ(above.size(), 1U);
  EXPECT_EQ(above[0].fault, SceneFault::stiffer_than_loop);
  EXPECT_THAT(above[0].what, HasSubstr("model-a in hand light at 1000 Hz with forces after 1 ms"));
  EXPECT_TRUE(check_stiffness(object_of(std::floor(gains.safe_n_per_m)), gains, 1000.0, 1e-3).empty()) << "the fix holds";
}

TEST(LoopCheck, OnlyMotorsThatTurnTheStylusLimitWhatTurns) {
  EXPECT_TRUE(check_turning("peg", 1e3, find_safe_gains(loops_for_check("model-a", "light"), 1000.0, 1e-3), 1000.0, 1e-3).empty());
  const auto loops = loops_for_check("model-a,model-a-6dof", "firm,light");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 1e-3);
  ASSERT_TRUE(gains.by_turning);
  EXPECT_EQ(gains.by_turning->device, "model-a-6dof");
  EXPECT_EQ(gains.by_turning->hand, "light");
  EXPECT_TRUE(check_turning("peg", gains.rotational_nm_per_rad, gains, 1000.0, 1e-3).empty());
  const CheckFindings above = check_turning("peg", 1.01 * gains.rotational_nm_per_rad, gains, 1000.0, 1e-3);
  ASSERT_EQ(above.size(), 1U);
  EXPECT_EQ(above[0].fault, SceneFault::tool_stiffer_than_loop);
  EXPECT_EQ(above[0].object, "peg");
  EXPECT_THAT(above[0].what, HasSubstr("model-a-6dof in hand light at 1000 Hz"));
  EXPECT_THAT(above[0].fix, HasSubstr("--rotational-stiffness 0.8"));
}

TEST(LoopCheck, EffectsCountAsStiffAsTheyAre) {
  const auto loops = loops_for_check("model-a", "light");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 1e-3);
  SceneObject layered = object_of(10.0 * gains.safe_n_per_m);
  layered.effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 0.5 * gains.safe_n_per_m});
  EXPECT_TRUE(check_stiffness(layered, gains, 1000.0, 1e-3).empty()) << "layers replace the spring of the material";
  layered.effects.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 1.1 * gains.safe_n_per_m});
  const CheckFindings findings = check_stiffness(layered, gains, 1000.0, 1e-3);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings[0].fix, HasSubstr("the stiffness_n_per_m of its layers"));
  const SceneEffect spring{.name = "home", .effect = SpringEffect{.stiffness_n_per_m = 1.1 * gains.safe_n_per_m}};
  const CheckFindings spring_findings = check_stiffness(spring, gains, 1000.0, 1e-3);
  ASSERT_EQ(spring_findings.size(), 1U);
  EXPECT_EQ(spring_findings[0].object, "effect home");
  EXPECT_TRUE(check_stiffness(SceneEffect{.name = "wind", .effect = ConstantEffect{}}, gains, 1000.0, 1e-3).empty());
}

// The check assumes the force with which the device can press, and the fix that it names is enough.
TEST(LoopCheck, BumpsAreStiffSideways) {
  const auto loops = loops_for_check("model-a", "light");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 5e-4);
  EXPECT_NEAR(gains.pressed_n, 8.45, 0.01);
  SceneObject object = object_of(800.0);
  object.effects.bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 0.0003, .length_m = 0.001};
  CheckFindings findings = check_stiffness(object, gains, 1000.0, 5e-4);
  ASSERT_FALSE(findings.empty());
  EXPECT_EQ(findings.back().fault, SceneFault::stiffer_than_loop);
  EXPECT_THAT(findings.back().what, HasSubstr("on its bumps, pressed with 8.5 N"));
  double advised_height_m = 0.0;
  ASSERT_EQ(
      std::sscanf(findings.back().fix.c_str(), "set its bump_height_m to %lf or less, or its bump_length_m to more", &advised_height_m), 1)
      << findings.back().fix;
  object.effects.bumps.height_m = advised_height_m;
  for (const CheckFinding& one : check_stiffness(object, gains, 1000.0, 5e-4)) EXPECT_NE(one.fault, SceneFault::stiffer_than_loop);
  object.effects.bumps.height_m = 1.2 * advised_height_m;
  EXPECT_FALSE(check_stiffness(object, gains, 1000.0, 5e-4).empty()) << "it is no lower than it has to be";
  // If the spring alone is already too stiff, the fix names the spring.
  object.material.stiffness_n_per_m = 2.0 * gains.safe_n_per_m;
  findings = check_stiffness(object, gains, 1000.0, 5e-4);
  ASSERT_FALSE(findings.empty());
  EXPECT_THAT(findings.back().fix, HasSubstr("set its stiffness_n_per_m to"));
}

// First the relief of an image, then the stiffness of an image.
TEST(LoopCheck, ImagesAreStiffWhereTheyChange) {
  const auto loops = loops_for_check("model-a", "light");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 5e-4);
  const std::vector<MappedTriangle> square = {
      {{Vec3(0, 0, 0), Vec3(0.008, 0, 0), Vec3(0.008, 0.008, 0)}, {Eigen::Vector2d(0, 0), {1, 0}, {1, 1}}},
      {{Vec3(0, 0, 0), Vec3(0.008, 0.008, 0), Vec3(0, 0.008, 0)}, {Eigen::Vector2d(0, 0), {1, 1}, {0, 1}}}};
  const auto image = std::make_shared<const SurfaceImage>(4, 1, std::vector<float>{0.0F, 0.5F, 1.0F, 0.5F});
  SceneObject object = object_of(800.0);
  object.effects.maps.triangles = std::make_shared<const std::vector<MappedTriangle>>(square);
  object.effects.maps.height = {.image = image, .at_black = -0.008, .at_white = 0.0};
  CheckFindings findings = check_stiffness(object, gains, 1000.0, 5e-4);
  ASSERT_EQ(findings.size(), 1U);
  double max_factor = 0.0;
  ASSERT_EQ(
      std::sscanf(findings[0].fix.c_str(), "multiply its bump_height_m (of a normal map: normal_map_scale) by %lf or less", &max_factor), 1)
      << findings[0].fix;
  object.effects.maps.height.at_black *= max_factor;
  EXPECT_TRUE(check_stiffness(object, gains, 1000.0, 5e-4).empty()) << max_factor;
  object.effects.maps.height = {};
  object.effects.maps.stiffness = {.image = image, .at_black = 0.1, .at_white = 1.0};
  findings = check_stiffness(object, gains, 1000.0, 5e-4);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings[0].what, HasSubstr("where its stiffness_map changes, pressed with 8.5 N"));
  EXPECT_THAT(findings[0].fix, HasSubstr("set the two numbers of its stiffness_map_n_per_m nearer to each other"));
}

// A device that is not known is assumed to press with 10 N; of several devices the strongest counts.
TEST(LoopCheck, SurfacesArePressedAsTheStrongestDeviceCan) {
  LoopFlags flags;
  flags.mass_kg = 0.2;
  flags.damping_ns_per_m = 5.0;
  EXPECT_EQ(find_safe_gains(*loops_of(flags), 1000.0, 1e-3).pressed_n, 10.0);
  EXPECT_EQ(find_safe_gains(loops_for_check("touch", "light"), 1000.0, 1e-3).pressed_n, 3.3);
  EXPECT_EQ(find_safe_gains(loops_for_check("touch,omega.3", "light"), 1000.0, 1e-3).pressed_n, 10.0);
}

TEST(LoopCheck, TheFixNamesTheKeyOfWhatIsStiff) {
  const auto loops = loops_for_check("model-a", "light");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 1e-3);
  const auto fix_of = [&](const SceneObject& object) {
    const CheckFindings findings = check_stiffness(object, gains, 1000.0, 1e-3);
    return findings.empty() ? std::string("nothing found") : findings.back().fix;
  };
  SceneObject object = object_of(60000.0);
  object.effects.maps.stiffness = {
      .image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F}), .at_black = 100.0 / 60000.0, .at_white = 1.0};
  EXPECT_THAT(fix_of(object), HasSubstr("set its stiffness_map_n_per_m to"));
  object = object_of(1000.0);
  object.effects.layers.add({.stiffness_n_per_m = 400.0});
  object.effects.snap = {.stiffness_n_per_m = 50000.0, .range_m = 0.01};
  EXPECT_THAT(fix_of(object), HasSubstr("set its snap_stiffness_n_per_m to"));
  const SceneEffect well{.name = "star", .effect = GravityWellEffect{.radius_m = 1e-4, .max_force_n = 8.0}};
  const CheckFindings findings = check_stiffness(well, gains, 1000.0, 1e-3);
  ASSERT_FALSE(findings.empty());
  EXPECT_THAT(findings.back().fix, HasSubstr("set 1.84 max_force_n / radius_m to"));
}

TEST(LoopCheck, DragOfLayersIsViscosity) {
  const auto loops = loops_for_check("model-a", "light");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 1e-3);
  SceneObject object = object_of(20.0);
  object.effects.layers.add({.pop_force_n = 1.0, .drag_ns_per_m = gains.viscosity_ns_per_m});
  EXPECT_TRUE(check_damping(object, gains, 1000.0, 1e-3, false).empty());
  object.effects.layers = {};
  object.effects.layers.add({.pop_force_n = 1.0, .drag_ns_per_m = 900.0});
  const CheckFindings findings = check_damping(object, gains, 1000.0, 1e-3, false);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].fault, SceneFault::more_damped_than_loop);
  EXPECT_THAT(findings[0].fix, HasSubstr("set the drag_ns_per_m of its layers to"));
}

TEST(LoopCheck, DampingIsHeldToHalfOfWhatIsStable) {
  const auto loops = loops_for_check("omega.3,touch", "light,firm");
  const SafeGains gains = find_safe_gains(loops, 1000.0, 1e-3);
  double safe_damping_ns_per_m = std::numeric_limits<double>::infinity();
  double safe_viscosity_ns_per_m = safe_damping_ns_per_m;
  for (const NamedLoop& loop : loops) {
    const Recommendation advice = recommend_stiffness(loop.device_model, loop.limits, loop.hand_model, 1000.0, 1e-3);
    safe_damping_ns_per_m = std::min(safe_damping_ns_per_m, advice.damping_ns_per_m);
    safe_viscosity_ns_per_m = std::min(safe_viscosity_ns_per_m, advice.viscosity_ns_per_m);
  }
  ASSERT_TRUE(gains.by_damping && gains.by_viscosity);
  EXPECT_EQ(gains.damping_ns_per_m, safe_damping_ns_per_m);
  EXPECT_EQ(gains.viscosity_ns_per_m, safe_viscosity_ns_per_m);
  SceneObject object = object_of(20.0);
  object.material.damping_ns_per_m = safe_damping_ns_per_m;
  object.effects.viscosity.damping_ns_per_m = safe_viscosity_ns_per_m;
  EXPECT_TRUE(check_damping(object, gains, 1000.0, 1e-3, false).empty());
  object.material.damping_ns_per_m = 1.01 * safe_damping_ns_per_m;
  CheckFindings findings = check_damping(object, gains, 1000.0, 1e-3, false);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(name_of(findings[0].fault), "more-damped-than-loop");
  EXPECT_EQ(findings[0].object, "lamp");
  EXPECT_THAT(findings[0].what, HasSubstr("touch in hand firm at 1000 Hz with forces after 1 ms is safe only up to"));
  EXPECT_THAT(findings[0].fix, HasSubstr("set its damping_ns_per_m to"));
  ASSERT_LT(safe_viscosity_ns_per_m, safe_damping_ns_per_m);
  object.material.damping_ns_per_m = 1.01 * safe_viscosity_ns_per_m;
  EXPECT_TRUE(check_damping(object, gains, 1000.0, 1e-3, false).empty());
  findings = check_damping(object, gains, 1000.0, 1e-3, true);
  ASSERT_EQ(findings.size(), 1U) << "a tool's contacts smooth the velocity";
  EXPECT_THAT(findings[0].fix, HasSubstr("set its damping_ns_per_m (at the contacts of a rigid tool or a held object) to"));
  object.material.damping_ns_per_m = safe_viscosity_ns_per_m;
  EXPECT_TRUE(check_damping(object, gains, 1000.0, 1e-3, true).empty());
  object.material.damping_ns_per_m = 0.0;
  object.effects.viscosity.damping_ns_per_m = 1.01 * safe_viscosity_ns_per_m;
  findings = check_damping(object, gains, 1000.0, 1e-3, false);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings[0].fix, HasSubstr("set its viscosity_ns_per_m to"));
  findings =
      check_damping({.name = "honey", .effect = ViscousEffect{.damping_ns_per_m = 1.01 * safe_viscosity_ns_per_m}}, gains, 1000.0, 1e-3);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].object, "effect honey");
  EXPECT_TRUE(
      check_damping({.name = "honey", .effect = ViscousEffect{.damping_ns_per_m = safe_viscosity_ns_per_m}}, gains, 1000.0, 1e-3).empty());
  EXPECT_TRUE(check_damping({.name = "wind", .effect = ConstantEffect{}}, gains, 1000.0, 1e-3).empty());
}

TEST(LoopCheck, NoEffectIsStrongerThanTheWeakestDevice) {
  const auto loops = loops_for_check("omega.3,touch", "light");
  EXPECT_TRUE(check_strength({.name = "wind", .effect = ConstantEffect{.force_n = Vec3(0, 0, 3.3)}}, loops).empty());
  const CheckFindings findings = check_strength({.name = "wind", .effect = ConstantEffect{.force_n = Vec3(2, 2, 2)}}, loops);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(name_of(findings[0].fault), "stronger-than-device");
  EXPECT_EQ(findings[0].what, "up to 3.46 N, but touch gives 3.3 N at most");
  LoopFlags flags;
  flags.mass_kg = 0.2;
  flags.damping_ns_per_m = 5.0;
  EXPECT_TRUE(check_strength({.name = "wind", .effect = ConstantEffect{.force_n = Vec3(50, 0, 0)}}, *loops_of(flags)).empty())
      << "the largest force of a loop from flags is not known";
}

TEST(LoopCheck, NoSurfaceIsStrongerThanTheWeakestDevice) {
  const auto loops = loops_for_check("omega.3,touch", "light");  // the weaker one, touch, gives 3.3 N
  SceneObject skin = object_of(20.0);
  EXPECT_TRUE(check_strength(skin, loops).empty());
  skin.effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 300.0, .pop_force_n = 3.3});
  skin.effects.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 300.0, .pop_force_n = 4.0});
  skin.effects.layers.add({.depth_m = 0.02, .stiffness_n_per_m = 300.0});
  CheckFindings findings = check_strength(skin, loops);
  ASSERT_EQ(findings.size(), 1U) << "bone never gives way";
  EXPECT_EQ(name_of(findings[0].fault), "stronger-than-device");
  EXPECT_EQ(findings[0].what, "layer 2 gives way at 4 N, but touch gives 3.3 N at most");
  EXPECT_THAT(findings[0].fix, HasSubstr("pop_force_n"));
  SceneObject tape = object_of(20.0);
  tape.effects.snap = {.stiffness_n_per_m = 300.0, .range_m = 0.02};
  findings = check_strength(tape, loops);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].what, "holds with up to 6 N, but touch gives 3.3 N at most");
  SceneObject bell = object_of(20.0);
  bell.effects.tap.max_force_n = 5.0;
  EXPECT_TRUE(check_strength(bell, loops).empty()) << "it is off";
  bell.effects.tap.ns_per_m = 5.0;
  findings = check_strength(bell, loops);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_THAT(findings[0].fix, HasSubstr("tap_max_force_n"));
}

TEST(LoopCheck, AVibrationNeedsTwoForcesAPeriod) {
  SceneObject bell = object_of(20.0);
  bell.effects.tap.frequency_hz = 900.0;
  EXPECT_TRUE(check_frequency(bell, 1000.0).empty()) << "it is off";
  bell.effects.tap.ns_per_m = 5.0;
  const CheckFindings findings = check_frequency(bell, 1000.0);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(name_of(findings[0].fault), "faster-than-loop");
  EXPECT_THAT(findings[0].fix, HasSubstr("tap_frequency_hz"));
  EXPECT_TRUE(check_frequency(bell, 2000.0).empty());
  EXPECT_EQ(check_frequency({.name = "hum", .effect = WaveEffect{.frequency_hz = 500.0}}, 1000.0).size(), 1U)
      << "all samples would be zero crossings";
  EXPECT_TRUE(check_frequency({.name = "hum", .effect = WaveEffect{.frequency_hz = 499.0}}, 1000.0).empty());
  EXPECT_EQ(check_frequency({.name = "click", .effect = BurstEffect{.frequency_hz = 600.0}}, 1000.0).size(), 1U);
  EXPECT_TRUE(check_frequency({.name = "wind", .effect = ConstantEffect{}}, 1000.0).empty());
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

TEST(LoopCheck, ALoopFromFlagsHasNoDocumentedLimit) {
  LoopFlags flags;
  flags.mass_kg = 0.2;
  flags.damping_ns_per_m = 5.0;
  const auto loops = loops_of(flags);
  ASSERT_TRUE(loops);
  const SafeGains gains = find_safe_gains(*loops, 1000.0, 1e-3);
  EXPECT_EQ(gains.by_device, nullptr);
  ASSERT_NE(gains.by_loop, nullptr);
  EXPECT_EQ(check_stiffness(object_of(1e6), gains, 1000.0, 1e-3).size(), 1U);
}

}  // namespace
}  // namespace hapton
