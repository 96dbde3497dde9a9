#include "core/force/stiffest.h"

#include <gtest/gtest.h>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchScene ball_of(const Material& material) { return {.objects = {{made::shared(made::sphere(0.05, 4)), material}}}; }

TEST(Stiffest, FindsTheStiffestOfTheObjects) {
  TouchScene scene = ball_of({.stiffness_n_per_m = 700.0});
  scene.objects.push_back(ball_of({.stiffness_n_per_m = 2500.0}).objects.front());
  EXPECT_EQ(find_largest_gains(scene).stiffness_n_per_m, 2500.0);
  EXPECT_EQ(find_largest_gains({}).stiffness_n_per_m, 0.0);
}

TEST(Stiffest, CountsWhatEffectsAdd) {
  TouchScene scene = ball_of({.stiffness_n_per_m = 700.0});
  scene.objects[0].effects.progressive.n_per_m2 = 1e5;
  EXPECT_DOUBLE_EQ(find_largest_gains(scene).stiffness_n_per_m, 700.0 + 2000.0)
      << "at d = 10 mm, c d^2 is 10 N and adds 2 c d to the spring";
  scene.objects[0].effects = {};
  scene.objects[0].effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 1.0});
  scene.objects[0].effects.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 650.0});
  EXPECT_EQ(find_largest_gains(scene).stiffness_n_per_m, 650.0) << "layers replace the spring of the material";
  scene.effects.push_back(SnapEffect{.range_m = 0.004, .max_force_n = 1.0});
  EXPECT_EQ(find_largest_gains(scene).stiffness_n_per_m, 1000.0);
  scene.effects.push_back(SpringEffect{.stiffness_n_per_m = 3000.0});
  EXPECT_EQ(find_largest_gains(scene).stiffness_n_per_m, 3000.0);
}

TEST(Stiffest, NamesTheCause) {
  const Material material{.stiffness_n_per_m = 700.0};
  SurfaceEffects effects;
  EXPECT_EQ(stiffest_spring_of(material, effects).cause, StiffCause::spring);
  effects.maps.stiffness.image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F});
  EXPECT_EQ(stiffest_spring_of(material, effects).cause, StiffCause::stiffness_map);
  effects = {};
  effects.progressive.n_per_m2 = 1e5;
  EXPECT_EQ(stiffest_spring_of(material, effects).cause, StiffCause::progressive);
  effects = {};
  effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0});
  EXPECT_EQ(stiffest_spring_of(material, effects).cause, StiffCause::layers);
  effects.snap = {.stiffness_n_per_m = 300.0, .range_m = 0.01};
  EXPECT_EQ(stiffest_spring_of(material, effects).cause, StiffCause::layers) << "the snap is less stiff";
  effects.snap.stiffness_n_per_m = 50000.0;
  EXPECT_EQ(stiffest_spring_of(material, effects).cause, StiffCause::surface_snap);
  EXPECT_EQ(stiffest_spring_of(material, effects).n_per_m, 50000.0);
  EXPECT_EQ(stiffest_of(SpaceEffect(SnapEffect{})).cause, StiffCause::snap_effect);
  EXPECT_EQ(stiffest_of(SpaceEffect(GravityWellEffect{})).cause, StiffCause::gravity_well);
  EXPECT_EQ(stiffest_of(SpaceEffect(MassEffect{})).cause, StiffCause::none);
  // 8 N over 0.1 mm, times 3 sqrt(3) / (2 sqrt(2)).
  EXPECT_NEAR(stiffest_of(SpaceEffect(GravityWellEffect{.radius_m = 1e-4, .max_force_n = 8.0})).n_per_m, 147000.0, 100.0);
}

TEST(Stiffest, BumpsCountWithTheForceThatPressesThem) {
  TouchScene scene = ball_of({.stiffness_n_per_m = 800.0});
  const Material material = scene.objects[0].material;
  EXPECT_EQ(stiffest_by_place_of(material, {}).n_per_m, 0.0);
  SurfaceEffects effects;
  effects.bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 0.0003, .length_m = 0.001};
  scene.objects[0].effects = effects;
  EXPECT_GT(stiffest_by_place_of(material, effects, 4.6).n_per_m, 27000.0);
  const LargestGains gains = find_largest_gains(scene);
  EXPECT_EQ(gains.stiffness_n_per_m, 800.0);
  EXPECT_EQ(gains.cause, StiffCause::spring);
  EXPECT_EQ(gains.by_place_n_per_m, stiffest_by_place_of(material, effects, kMaxPressedN).n_per_m);
  EXPECT_EQ(gains.place_cause, StiffCause::bumps);
  for (const double pressed_n : {0.0, 0.1, 0.5, 1.0, 3.3, 8.5, 10.0}) {
    const double exact = stiffest_by_place_of(material, effects, pressed_n).n_per_m;
    EXPECT_GE(gains.by_place_at(pressed_n), (1.0 - 1e-12) * exact) << pressed_n << " N";
    EXPECT_LE(gains.by_place_at(pressed_n), 1.5 * exact) << pressed_n << " N";
  }
  EXPECT_EQ(gains.by_place_at(30.0), gains.by_place_n_per_m) << "a larger force counts as the largest";
  // A tool feels no bumps.
  EXPECT_EQ(find_tool_gains(scene).by_place_n_per_m, 0.0);
  EXPECT_EQ(find_largest_gains(scene).stiffness_n_per_m, 800.0);
  // A second object: its bumps are less stiff at the largest force, but stiffer at small forces.
  scene.objects.push_back(ball_of({.stiffness_n_per_m = 5000.0}).objects.front());
  scene.objects[1].effects.bumps = {.height_m = 0.001, .length_m = 0.02};
  const LargestGains both = find_largest_gains(scene);
  EXPECT_EQ(both.by_place_n_per_m, gains.by_place_n_per_m);
  EXPECT_GE(both.by_place_at(0.0), 5000.0);
}

// A layer is never pressed with more force than punctures it, so a force below the largest one may already feel as stiff.
TEST(Stiffest, BumpsOnLayersCountInFull) {
  TouchScene scene = ball_of({});
  SurfaceEffects& effects = scene.objects[0].effects;
  effects.bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 0.0003, .length_m = 0.001};
  effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 2.0});
  effects.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 300.0});
  const LargestGains gains = find_largest_gains(scene);
  for (const double pressed_n : {0.5, 2.0, 3.3, 10.0})
    EXPECT_GE(gains.by_place_at(pressed_n), stiffest_by_place_of(scene.objects[0].material, effects, pressed_n).n_per_m) << pressed_n;
}

TEST(Stiffest, DragOfLayersIsViscosity) {
  TouchScene scene = ball_of({});
  SurfaceEffects& effects = scene.objects[0].effects;
  effects.layers.add({.depth_m = 0.0, .pop_force_n = 1.0, .drag_ns_per_m = 900.0});
  effects.layers.add({.depth_m = 0.01, .drag_ns_per_m = 2000.0});
  EXPECT_DOUBLE_EQ(drag_of(effects), 900.0) << "the last layer is never punctured";
  EXPECT_DOUBLE_EQ(find_largest_gains(scene).viscosity_ns_per_m, 900.0);
  EXPECT_EQ(find_tool_gains(scene).viscosity_ns_per_m, 0.0);
  EXPECT_EQ(drag_of({}), 0.0);
}

TEST(Stiffest, TheLargestGainsAreThoseOfAllObjectsAndEffects) {
  TouchScene scene = ball_of({.stiffness_n_per_m = 700.0, .damping_ns_per_m = 3.0});
  scene.objects.push_back(ball_of({.stiffness_n_per_m = 100.0, .damping_ns_per_m = 7.0}).objects.front());
  scene.objects.push_back(ball_of({.stiffness_n_per_m = 200.0}).objects.front());
  scene.objects[1].effects.viscosity.damping_ns_per_m = 4.0;
  LargestGains gains = find_largest_gains(scene);
  EXPECT_EQ(gains.stiffness_n_per_m, 700.0);
  EXPECT_EQ(gains.damping_ns_per_m, 7.0);
  EXPECT_EQ(gains.viscosity_ns_per_m, 4.0);
  scene.effects.push_back(SpringEffect{.stiffness_n_per_m = 3000.0});
  scene.effects.push_back(ViscousEffect{.damping_ns_per_m = 9.0});
  gains = find_largest_gains(scene);
  EXPECT_EQ(gains.stiffness_n_per_m, 3000.0);
  EXPECT_EQ(gains.damping_ns_per_m, 7.0);
  EXPECT_EQ(gains.viscosity_ns_per_m, 9.0);
  EXPECT_EQ(find_largest_gains({}).viscosity_ns_per_m, 0.0);
}

TEST(Stiffest, AViscosityByAnImageCountsWithItsLargestValue) {
  const auto image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F});
  EXPECT_EQ(viscosity_of(SurfaceEffects{.maps = {.viscosity = {.image = image, .at_black = 7.0, .at_white = 2.0}}}), 7.0);
  EXPECT_EQ(viscosity_of(SurfaceEffects{.maps = {.viscosity = {.image = nullptr, .at_black = 7.0, .at_white = 2.0}}}), 0.0);
}

// At the contacts of a tool, damping and viscosity both use the velocity of viscous effects.
TEST(Stiffest, AToolHasDampingAndViscosityUnderOneLimit) {
  TouchScene scene{.objects = {{.mesh = {}, .material = {.stiffness_n_per_m = 300.0, .damping_ns_per_m = 5.0}}}};
  scene.objects[0].effects.viscosity.damping_ns_per_m = 9.0;
  scene.effects = {ViscousEffect{.damping_ns_per_m = 4.0}, SpringEffect{.stiffness_n_per_m = 900.0}};
  const LargestGains gains = find_tool_gains(scene);
  EXPECT_EQ(gains.stiffness_n_per_m, 900.0);
  EXPECT_EQ(gains.damping_ns_per_m, 0.0);
  EXPECT_EQ(gains.viscosity_ns_per_m, 9.0);
  EXPECT_EQ(find_largest_gains(scene).viscosity_ns_per_m, 9.0);
  scene.objects[0].material.damping_ns_per_m = 11.0;
  EXPECT_EQ(find_tool_gains(scene).viscosity_ns_per_m, 11.0);
  EXPECT_EQ(find_largest_gains(scene).viscosity_ns_per_m, 9.0) << "a point has the two under limits of their own";
  scene.effects.push_back(ViscousEffect{.damping_ns_per_m = 12.0});
  EXPECT_EQ(find_tool_gains(scene).viscosity_ns_per_m, 12.0);
  EXPECT_EQ(find_largest_gains(scene).viscosity_ns_per_m, 12.0);
  // Images are not felt with a tool.
  scene.effects.clear();
  const auto image = std::make_shared<const SurfaceImage>(1, 1, std::vector<float>{0.5F});
  scene.objects[0].effects.maps.viscosity = {.image = image, .at_black = 70.0, .at_white = 20.0};
  EXPECT_EQ(find_tool_gains(scene).viscosity_ns_per_m, 11.0);
}

TEST(Stiffest, TheLargerGainsOfPointAndToolCount) {
  const LargestGains both = LargestGains{.stiffness_n_per_m = 3.0, .damping_ns_per_m = 2.0, .viscosity_ns_per_m = 1.0}.largest_of(
      {.stiffness_n_per_m = 2.0, .damping_ns_per_m = 3.0, .viscosity_ns_per_m = 4.0, .rotational_nm_per_rad = 0.5});
  EXPECT_EQ(both.stiffness_n_per_m, 3.0);
  EXPECT_EQ(both.damping_ns_per_m, 3.0);
  EXPECT_EQ(both.viscosity_ns_per_m, 4.0);
  EXPECT_EQ(both.rotational_nm_per_rad, 0.5);
  EXPECT_TRUE(LargestGains{.rotational_nm_per_rad = 0.5}.any());
  EXPECT_FALSE(LargestGains().any());
}

TEST(Stiffest, TheStiffestSurfaceLeavesOutEffectsInFreeSpace) {
  TouchScene scene{.objects = {{.mesh = {}, .material = {.stiffness_n_per_m = 300.0}}},
                   .effects = {SpringEffect{.stiffness_n_per_m = 900.0}}};
  EXPECT_EQ(find_largest_gains(scene).stiffness_n_per_m, 900.0);
  EXPECT_EQ(find_stiffest_surface(scene), 300.0);
}

}  // namespace
}  // namespace hapton
