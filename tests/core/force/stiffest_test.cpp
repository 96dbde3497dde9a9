#include "core/force/stiffest.h"

#include <gtest/gtest.h>

#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchScene ball_of(const Material& material) { return {.objects = {{made::shared(made::sphere(0.05, 4)), material}}}; }

TEST(Stiffest, FindsTheStiffestOfTheObjects) {
  TouchScene scene = ball_of({.stiffness_n_per_m = 700.0});
  scene.objects.push_back(ball_of({.stiffness_n_per_m = 2500.0}).objects.front());
  EXPECT_EQ(find_stiffest(scene), 2500.0);
  EXPECT_EQ(find_stiffest({}), 0.0);
}

TEST(Stiffest, CountsWhatEffectsAdd) {
  TouchScene scene = ball_of({.stiffness_n_per_m = 700.0});
  scene.objects[0].effects.progressive.n_per_m2 = 1e5;
  EXPECT_DOUBLE_EQ(find_stiffest(scene), 700.0 + 2000.0) << "d = 10 mm: 10 N, and 2 c d beside the spring";
  scene.objects[0].effects = {};
  scene.objects[0].effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 1.0});
  scene.objects[0].effects.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 650.0});
  EXPECT_EQ(find_stiffest(scene), 650.0) << "layers replace the spring of the material";
  scene.effects.push_back(SnapEffect{.range_m = 0.004, .max_force_n = 1.0});
  EXPECT_EQ(find_stiffest(scene), 1000.0);
  scene.effects.push_back(SpringEffect{.stiffness_n_per_m = 3000.0});
  EXPECT_EQ(find_stiffest(scene), 3000.0);
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

// At its contacts both use the velocity of viscous effects.
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

TEST(Stiffest, OfPointAndToolByTurnsTheLargestCount) {
  const LargestGains both = LargestGains{.stiffness_n_per_m = 3.0, .damping_ns_per_m = 2.0, .viscosity_ns_per_m = 1.0}.largest_of(
      {.stiffness_n_per_m = 2.0, .damping_ns_per_m = 3.0, .viscosity_ns_per_m = 4.0});
  EXPECT_EQ(both.stiffness_n_per_m, 3.0);
  EXPECT_EQ(both.damping_ns_per_m, 3.0);
  EXPECT_EQ(both.viscosity_ns_per_m, 4.0);
}

TEST(Stiffest, SurfacesAloneLeaveOutTheSpace) {
  TouchScene scene{.objects = {{.mesh = {}, .material = {.stiffness_n_per_m = 300.0}}},
                   .effects = {SpringEffect{.stiffness_n_per_m = 900.0}}};
  EXPECT_EQ(find_stiffest(scene), 900.0);
  EXPECT_EQ(find_stiffest_surface(scene), 300.0);
}

}  // namespace
}  // namespace hapton
