#include "core/effects/surface_drag.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/effects/effect_step.h"

namespace hapton {
namespace {

constexpr double kDragSpring = 1000.0;  // N/m

// A step as with a force method without damping and friction that touches the plane z = 0.
EffectResult press_plane(EffectStep& step, const Vec3& p) {
  SurfaceContact contact{.p_SP = p};
  if (p.z() < 0.0) contact = {.force_n = {0, 0, -kDragSpring * p.z()}, .p_SP = {p.x(), p.y(), 0}, .object = 0, .contact = true};
  return step.step(p, 1e-3, contact);
}

TEST(SurfaceDrag, DampingWorksAgainstTheNormalSpeedAndNeverAttracts) {
  EffectStep step({SurfaceEffects{.drag = {.damping_ns_per_m = 5.0}}}, {});
  (void)press_plane(step, {0, 0, 1e-4});
  // 0.1 m/s inwards, whatever the motion along the surface.
  for (int n = 1; n <= 20; ++n)
    EXPECT_NEAR(press_plane(step, {3e-4 * n, 0, 1e-4 - 1e-4 * n}).force_n.z(), 0.1 * (n - 1) + (n > 1 ? 0.5 : 0.0), 1e-9) << n;
  EXPECT_NEAR(press_plane(step, {6e-3, 0, -1.8e-3}).force_n.z(), 1.8 - 0.5, 1e-9) << "outwards";
  EXPECT_EQ(press_plane(step, {6e-3, 0, -0.5e-3}).force_n.z(), 0.0) << "1.3 m/s: 6.5 N";
}

TEST(SurfaceDrag, FrictionSticksAndSlips) {
  EffectStep step({SurfaceEffects{.drag = {.friction = {0.8, 0.4}}}}, {});
  (void)press_plane(step, {0, 0, 1e-4});
  (void)press_plane(step, {0, 0, -2e-3});
  for (int n = 1; n < 40; ++n) {
    const Vec3 force_n = press_plane(step, {1e-4 * n, 0, -2e-3}).force_n;
    EXPECT_NEAR(force_n.z(), 2.0, 1e-9);
    EXPECT_NEAR(force_n.x(), n <= 16 ? -0.1 * n : -0.8, 1e-9) << n;
  }
  // After the device has been lifted and put down elsewhere, friction begins anew.
  (void)press_plane(step, {4e-3, 0, 1e-4});
  EXPECT_NEAR(press_plane(step, {8e-3, 0, -2e-3}).force_n.x(), 0.0, 1e-12);
}

// In the layer of method smooth, where a spring acts before the surface (smooth_force.h), the force is large where the depth is small.
TEST(SurfaceDrag, TheSpringOfFrictionIsNoStifferThanTheMaterial) {
  EffectStep step({SurfaceEffects{.drag = {.stiffness_n_per_m = kDragSpring, .friction = {0.5, 0.5}}}}, {});
  const auto friction_n = [&](double x_m) {
    return -step.step({x_m, 0, -1e-5}, 1e-3, {.force_n = {0, 0, 2.0}, .p_SP = {x_m, 0, 0}, .object = 0, .contact = true}).force_n.x();
  };
  (void)friction_n(0.0);
  for (int n = 1; n <= 20; ++n) EXPECT_NEAR(friction_n(1e-4 * n), std::min(1.0, kDragSpring * 1e-4 * n), 1e-9) << n;
}

TEST(SurfaceDrag, CanBeSetWhileItIsFeltAndLayersReplaceTheDamping) {
  TissueLayers layers;
  layers.add({.depth_m = 0.0, .stiffness_n_per_m = kDragSpring});
  EffectStep with_layers({SurfaceEffects(), SurfaceEffects{.layers = layers}}, {});
  EXPECT_TRUE(with_layers.any()) << "the layers";
  EffectStep without_layers({SurfaceEffects()}, {});
  EXPECT_FALSE(without_layers.any());
  without_layers.set_drag(0, {.friction = {0.5, 0.5}});
  EXPECT_TRUE(without_layers.any());
  (void)press_plane(without_layers, {0, 0, -1e-3});
  EXPECT_NEAR(press_plane(without_layers, {1e-3, 0, -1e-3}).force_n.x(), -0.5, 1e-9);
  without_layers.set_drag(0, {});
  EXPECT_NEAR(press_plane(without_layers, {2e-3, 0, -1e-3}).force_n.norm(), 1.0, 1e-9);
  with_layers.set_drag(1, {.damping_ns_per_m = 5.0});
  const auto in_layers = [&](double z_m) {
    return with_layers.step({0, 0, z_m}, 1e-3, {.force_n = {0, 0, -kDragSpring * z_m}, .p_SP = Vec3::Zero(), .object = 1, .contact = true})
        .force_n.z();
  };
  (void)in_layers(-1e-4);
  EXPECT_NEAR(in_layers(-2e-4), 0.2, 1e-9) << "without damping";
}

TEST(SurfaceDrag, FrictionBeginsAnewAfterASurfaceWithoutIt) {
  EffectStep step({SurfaceEffects{.drag = {.friction = {0.5, 0.5}}}, SurfaceEffects()}, {});
  const auto press = [&](double x_m, int object) {
    return step.step({x_m, 0, -2e-3}, 1e-3, {.force_n = {0, 0, 2.0}, .p_SP = {x_m, 0, 0}, .object = object, .contact = true}).force_n;
  };
  (void)press(0.0, 0);
  EXPECT_NEAR(press(5e-3, 0).x(), -1.0, 1e-9);
  EXPECT_EQ(press(6e-3, 1), Vec3(0, 0, 2.0));
  EXPECT_NEAR(press(5.9e-3, 0).x(), 0.1, 1e-9) << "against the motion back, by that alone";
}

// The device goes in, along the surface, round and out on a wavy path: the hand never gets more energy than it gave.
TEST(SurfaceDrag, TakesEnergy) {
  for (const double damping : {0.0, 4.0}) {
    EffectStep step({SurfaceEffects{.drag = {.damping_ns_per_m = damping, .friction = {0.7, 0.3}}}}, {});
    double energy_from_hand_j = 0.0;
    Vec3 last(0, 0, 1e-3);
    (void)press_plane(step, last);
    for (int n = 0; n < 50'000; ++n) {
      const double t = 1e-3 * n;
      const Vec3 p(0.01 * std::sin(7.0 * t), 0.008 * std::sin(11.0 * t + 1.0), 1e-3 - 2e-3 * std::pow(std::sin(3.0 * t), 2));
      const Vec3 force_n = press_plane(step, p).force_n;
      energy_from_hand_j -= force_n.dot(p - last);
      last = p;
    }
    EXPECT_GT(energy_from_hand_j, 0.05) << damping;
  }
}

}  // namespace
}  // namespace hapton
