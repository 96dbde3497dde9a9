#include "core/effects/effect_step.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>
#include <span>

#include "tests/core/effects/effect_paths.h"
#include "tests/core/effects/made_textures.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kMs = 1e-3;
constexpr double kSpring = 1000.0;  // N/m

// The contact that a method without friction finds on the plane z = 0.
SurfaceContact on_plane(const Vec3& p_SD, int object = 0) {
  if (!(p_SD.z() < 0.0)) return {.p_SP = p_SD};
  return {.force_n = {0, 0, -kSpring * p_SD.z()}, .p_SP = {p_SD.x(), p_SD.y(), 0}, .object = object, .contact = true};
}

EffectResult press(EffectStep& step, const Vec3& p_SD) { return step.step(p_SD, kMs, on_plane(p_SD)); }

SurfaceEffects all_surface_effects() {
  static const auto models = made::texture(1000.0, 20, 18);
  return {.progressive = {.n_per_m2 = 1e5},
          .layers = {},
          .bumps = {.height_m = 1e-3, .length_m = 5e-3},
          .viscosity = {.damping_ns_per_m = 4},
          .snap = {.range_m = 2e-3},
          .tap = {.ns_per_m = 5},
          .texture = {.models = models}};
}

std::vector<SwitchedEffect> all_space_effects() {
  return {SpringEffect{},
          ConstantEffect{.force_n = {0, -0.3, 0}},
          SnapEffect{},
          SnapEffect{.target = SnapEffect::Target::line},
          SnapEffect{.target = SnapEffect::Target::plane},
          GravityWellEffect{},
          ViscousEffect{},
          MassEffect{},
          WaveEffect{},
          BurstEffect{.volume = EffectVolume::ball(Vec3::Zero(), 0.01)},
          {SpringEffect{}, EffectSwitch{.button = 1}},
          {BurstEffect{}, EffectSwitch{.button = 2}}};
}

TEST(EffectStep, WithoutEffectsIsTheMethodsForce) {
  EffectStep step({SurfaceEffects()}, {});
  const EffectResult pressed = press(step, {0.1, 0.2, -0.002});
  EXPECT_EQ(pressed.force_n, Vec3(0, 0, 2.0));
  EXPECT_EQ(pressed.p_SP, Vec3(0.1, 0.2, 0));
  EXPECT_TRUE(pressed.is_felt);
  const EffectResult free = press(step, {0.1, 0.2, 0.002});
  EXPECT_EQ(free.force_n, Vec3::Zero());
  EXPECT_FALSE(free.is_felt);
}

// On a triangle compressed ten times along x, bumps without a limit would be ten times as steep, and so would the force.
TEST(EffectStep, BumpsOnACompressedSurfaceAreNoSteeperThanOthers) {
  EffectStep step({SurfaceEffects{.bumps = {.height_m = 1e-3, .length_m = 4e-3}}}, {});
  const SurfacePlace place{.p_rest = Vec3(1e-3, 0, 0), .moved = Vec3::Zero(), .gradient = Vec3(10.0, 1.0, 1.0).asDiagonal()};
  SurfaceContact contact = on_plane({0, 0, -0.003});
  contact.place = &place;
  const Vec3 force_n = step.step({0, 0, -0.003}, kMs, contact).force_n;
  EXPECT_GT(force_n.z(), 1.0);
  EXPECT_NEAR(force_n.head<2>().norm() / force_n.z(), SurfaceMaps::kSteepest, 1e-12);
}

TEST(EffectStep, AddsProgressiveStiffness) {
  EffectStep step({SurfaceEffects{.progressive = {.n_per_m2 = 2e5}}}, {});
  EXPECT_LT((press(step, {0, 0, -0.003}).force_n - Vec3(0, 0, 3.0 + 1.8)).norm(), 1e-12);
}

// When the hand slides, method `sweep` finds the contact point late: on the same plane, but far behind the hand.
TEST(EffectStep, DepthIsThatBelowThePlaneWhereverItsContactPointLags) {
  const Vec3 p(0, 0, -0.003);
  for (const double behind_m : {0.0, 1e-3, 0.02}) {
    const SurfaceContact late = {.force_n = {0, 0, 3.0}, .p_SP = {-behind_m, 0, 0}, .object = 0, .contact = true};
    EffectStep firm({SurfaceEffects{.progressive = {.n_per_m2 = 2e5}}}, {});
    EXPECT_LT((firm.step(p, kMs, late).force_n - Vec3(0, 0, 4.8)).norm(), 1e-12) << behind_m;
    TissueLayers layers;
    layers.add({.depth_m = 0.0, .stiffness_n_per_m = 200.0});
    EffectStep soft({SurfaceEffects{.layers = layers}}, {});
    EXPECT_LT((soft.step(p, kMs, late).force_n - Vec3(0, 0, 0.6)).norm(), 1e-12) << behind_m;
  }
}

TEST(EffectStep, TakesTheEffectsOfTheObjectTouched) {
  EffectStep step({SurfaceEffects(), SurfaceEffects{.progressive = {.n_per_m2 = 2e5}}}, {});
  const Vec3 p(0, 0, -0.003);
  EXPECT_NEAR(step.step(p, kMs, on_plane(p, 0)).force_n.z(), 3.0, 1e-12);
  EXPECT_NEAR(step.step(p, kMs, on_plane(p, 1)).force_n.z(), 4.8, 1e-12);
  EXPECT_NEAR(step.step(p, kMs, on_plane(p, -1)).force_n.z(), 3.0, 1e-12) << "unknown";
  EXPECT_NEAR(step.step(p, kMs, on_plane(p, 7)).force_n.z(), 3.0, 1e-12) << "no such object";
}

TEST(EffectStep, BumpsLowerTheSurfaceAndPushSideways) {
  const SurfaceBumps bumps = {.pattern = SurfaceBumps::Pattern::ridges, .height_m = 1e-3, .length_m = 4e-3};
  EffectStep step({SurfaceEffects{.bumps = bumps}}, {});
  EXPECT_LT((press(step, {0, 0, -0.003}).force_n - Vec3(0, 0, 3)).norm(), 1e-9) << "on the crest";
  EXPECT_LT((press(step, {0.002, 0, -0.003}).force_n - Vec3(0, 0, 2)).norm(), 1e-9) << "in the trough";
  // Half way down the bump: 2.5 mm deep, and a force down the slope, towards +x.
  EXPECT_LT((press(step, {0.001, 0, -0.003}).force_n - Vec3(2.5 * bumps.slope(), 0, 2.5)).norm(), 1e-9);
  const EffectResult above = press(step, {0.002, 0, -0.0008});
  EXPECT_EQ(above.force_n, Vec3::Zero()) << "in the trough, above the bottom";
}

// The whole surface force with bumps, without and with progressive stiffness, over closed paths in and out of contact.
TEST(EffectStep, BumpsAndProgressiveStiffnessGiveNoEnergyOverAClosedPath) {
  for (const double progressive : {0.0, 1e5}) {
    for (const auto pattern : {SurfaceBumps::Pattern::ridges, SurfaceBumps::Pattern::grid}) {
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        EffectStep step(
            {SurfaceEffects{.progressive = {.n_per_m2 = progressive}, .bumps = {.pattern = pattern, .height_m = 1e-3, .length_m = 4e-3}}},
            {});
        const auto work = paths::work_along(paths::closed(seed, 50000, {0, 0, -0.002}, 0.006),
                                            [&](const Vec3& p) { return step.step(p, kMs, on_plane(p)).force_n; });
        EXPECT_LT(std::abs(work.net_j), 1e-5 * work.absolute_j) << "seed " << seed;
      }
    }
  }
}

// Viscosity and snap only take energy. At 1 kHz the zero-order hold itself gives a spring of stiffness k at most k/2 |dx|^2 a step. So the
// work of a step is its motion times the mean of the forces before and after it, as the hand feels it (trapezoidal rule).
TEST(EffectStep, ViscosityAndSnapTakeEnergyOverAClosedPath) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    EffectStep step({SurfaceEffects{.viscosity = {.damping_ns_per_m = 6}, .snap = {.stiffness_n_per_m = 300, .range_m = 2e-3}}}, {});
    const auto path = paths::closed(seed, 20000, {0, 0, 0.0005}, 0.006);
    Vec3 before_n = Vec3::Zero();
    double energy_to_hand_j = 0.0;
    Vec3 last = path[0];
    press(step, last);
    for (std::size_t i = 1; i <= path.size(); ++i) {
      const Vec3& p = path[i % path.size()];
      const Vec3 force_n = press(step, p).force_n;
      energy_to_hand_j += 0.5 * (before_n + force_n).dot(p - last);
      before_n = force_n;
      last = p;
    }
    EXPECT_LT(energy_to_hand_j, 0.0) << "seed " << seed;
  }
}

TEST(EffectStep, ANeedleGoesThroughTheSkin) {
  SurfaceEffects skin;
  skin.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 500, .pop_force_n = 1.0});
  skin.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 2000});
  EffectStep step({skin}, {});
  EXPECT_NEAR(press(step, {0, 0, -0.0018}).force_n.z(), 0.9, 1e-12);
  EXPECT_EQ(press(step, {0, 0, -0.0018}).p_SP, Vec3::Zero()) << "drawn on the skin";
  const EffectResult through = press(step, {0, 0, -0.0025});
  EXPECT_EQ(through.force_n, Vec3::Zero());
  EXPECT_EQ(through.p_SP, Vec3(0, 0, -0.0025)) << "drawn where it is";
  EXPECT_TRUE(through.is_felt) << "still in contact";
  const EffectResult bone = press(step, {0, 0, -0.011});
  EXPECT_NEAR(bone.force_n.z(), 2.0, 1e-9);
  EXPECT_LT((bone.p_SP - Vec3(0, 0, -0.01)).norm(), 1e-12) << "drawn on the bone";
  EXPECT_EQ(press(step, {0, 0, -0.001}).force_n, Vec3::Zero()) << "drawn back";
  press(step, {0, 0, 0.001});
  EXPECT_NEAR(press(step, {0, 0, -0.001}).force_n.z(), 0.5, 1e-12) << "whole again";
}

TEST(EffectStep, ATapRingsAtTheSpeedOfTheImpact) {
  const TapVibration metal = {.ns_per_m = 5, .frequency_hz = 100, .decay_s = 0.02, .max_force_n = 2};
  EffectStep step({SurfaceEffects{.tap = metal}}, {});
  press(step, {0, 0, 0.0001});
  press(step, {0, 0, -0.0001});  // at 0.2 m/s
  for (int k = 1; k < 20; ++k) {
    const double expected = 0.1 + 1.0 * decaying_sine(kMs * k, 100, 0.02);
    EXPECT_NEAR(press(step, {0, 0, -0.0001}).force_n.z(), expected, 1e-9) << k;
  }
  step.reset();
  press(step, {0, 0, -0.0001});
  EXPECT_NEAR(press(step, {0, 0, -0.0001}).force_n.z(), 0.1, 1e-12) << "a step that begins in contact has not tapped";
}

// A probe between two objects may be pushed more by one, then by the other. That does not count as a tap, and punctures stay.
TEST(EffectStep, GoingBackAndForthBetweenObjectsIsOneContact) {
  SurfaceEffects skin;
  skin.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 500, .pop_force_n = 1.0});
  skin.layers.add({.depth_m = 0.01, .stiffness_n_per_m = 2000});
  EffectStep step({skin, SurfaceEffects{.tap = {.ns_per_m = 5}}}, {});
  const auto touch = [&](double z, int object) { return step.step({0, 0, z}, kMs, on_plane({0, 0, z}, object)).force_n.z(); };
  touch(0.001, 0);
  touch(-0.001, 0);
  EXPECT_EQ(touch(-0.003, 0), 0.0) << "punctured";
  for (int k = 1; k < 10; ++k) {
    EXPECT_NEAR(touch(-0.003 - 1e-4 * k, 1), 3.0 + 0.1 * k, 1e-9) << "no tap";
    EXPECT_EQ(touch(-0.003 - 1e-4 * k, 0), 0.0) << "still punctured";
  }
  touch(0.001, 0);
  EXPECT_NEAR(touch(-0.001, 0), 0.5, 1e-12) << "a contact of its own";
}

TEST(EffectStep, ASurfaceHoldsOnUntilOutOfRange) {
  EffectStep step({SurfaceEffects{.snap = {.stiffness_n_per_m = 300, .range_m = 2e-3}}}, {});
  EXPECT_EQ(press(step, {0, 0, 0.001}).force_n, Vec3::Zero());
  press(step, {0, 0, -0.001});
  const EffectResult snapped = press(step, {0, 0, 0.001});
  EXPECT_NEAR(snapped.force_n.z(), -0.3, 1e-12);
  EXPECT_TRUE(snapped.is_felt);
  EXPECT_EQ(snapped.p_SP, Vec3(0, 0, 0.001));
  EXPECT_FALSE(press(step, {0, 0, 0.0021}).is_felt);
}

TEST(EffectStep, SpaceEffectsActInContactAndOutside) {
  EffectStep step({SurfaceEffects()}, {ConstantEffect{.force_n = {0.5, 0, 0}}, WaveEffect{.amplitude_n = 0.2, .frequency_hz = 50}});
  for (int k = 1; k < 40; ++k) {
    const Vec3 p(0, 0, k % 2 == 0 ? 0.001 : -0.001);
    const Vec3 wave(0, 0, 0.2 * std::sin(2 * std::numbers::pi * 50 * kMs * k));
    EXPECT_LT((press(step, p).force_n - on_plane(p).force_n - Vec3(0.5, 0, 0) - wave).norm(), 1e-9) << k;
  }
}

// The force in free space, where no surface is near.
Vec3 free_force(EffectStep& step, const Vec3& p, std::uint32_t buttons) { return step.step(p, kMs, {}, buttons).force_n; }

// The force is gain * F, both in closed form; no step of it is larger than the ramp allows.
TEST(EffectStep, AnEffectWithAButtonActsWhileItIsHeld) {
  const SpringEffect spring = {.centre = {0.01, 0, 0}, .stiffness_n_per_m = 100, .max_force_n = 3};
  EffectStep step({}, {{spring, EffectSwitch{.button = 2}}, ConstantEffect{.force_n = {0, 0.5, 0}}});
  Vec3 before = Vec3(0, 0.5, 0);
  for (int n = 0; n < 200; ++n) {
    const bool is_down = n >= 20 && n < 120;
    const Vec3 force_n = free_force(step, {0.0, 0, 0}, is_down ? 2 : 1);
    const double gain = std::clamp((n - 20) / 20.0, 0.0, 1.0) - std::clamp((n - 120) / 20.0, 0.0, 1.0);
    EXPECT_LT((force_n - Vec3(gain * 1.0, 0.5, 0)).norm(), 1e-12) << n;
    EXPECT_LT((force_n - before).norm(), 1.0 * kMs / EffectSwitch::kRampS + 1e-12) << n;
    before = force_n;
  }
}

TEST(EffectStep, TheTimeOfAWaveWithAButtonBeginsWithThePress) {
  EffectStep step({}, {{WaveEffect{.amplitude_n = 0.2, .frequency_hz = 30}, EffectSwitch{.button = 1}}});
  for (int n = 0; n < 100; ++n) {
    const Vec3 force_n = free_force(step, Vec3::Zero(), n >= 33 ? 1 : 0);
    const double since_s = kMs * (n - 33);
    const double gain = std::clamp(since_s / EffectSwitch::kRampS, 0.0, 1.0);
    EXPECT_NEAR(force_n.z(), gain * 0.2 * std::sin(2 * std::numbers::pi * 30 * since_s), 1e-9) << n;
  }
}

TEST(EffectStep, ABurstWithAButtonBeginsWithEachPressInside) {
  const BurstEffect burst = {
      .amplitude_n = 1.5, .frequency_hz = 80, .decay_s = 0.02, .duration_s = 0.1, .volume = EffectVolume::ball(Vec3::Zero(), 0.01)};
  EffectStep step({}, {{burst, EffectSwitch{.button = 1}}});
  const auto ring = [&](double since_s) {
    return since_s < 0.1 ? 1.5 * std::exp(-since_s / 0.02) * std::sin(2 * std::numbers::pi * 80 * since_s) : 0.0;
  };
  free_force(step, {0, 0, 0.02}, 0);
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(free_force(step, Vec3::Zero(), 0).isZero(0.0)) << "entering starts nothing";
  // The burst rings on after the release of the button, and outside the volume.
  for (int n = 0; n < 150; ++n) EXPECT_NEAR(free_force(step, {0, 0, n > 20 ? 0.02 : 0.0}, n < 5 ? 1 : 0).z(), ring(kMs * n), 1e-9) << n;
  free_force(step, {0, 0, 0.02}, 0);
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(free_force(step, {0, 0, 0.02}, 1).isZero(0.0)) << "pressed outside";
  for (int n = 0; n < 10; ++n) EXPECT_TRUE(free_force(step, Vec3::Zero(), 1).isZero(0.0)) << "the press was outside";
  free_force(step, Vec3::Zero(), 0);
  for (int n = 0; n < 30; ++n) EXPECT_NEAR(free_force(step, Vec3::Zero(), 1).z(), ring(kMs * n), 1e-9) << n;
}

// From a press to the end of the fade, a switched spring gives at most its bound times the length of the path. Here it gives almost as
// much: the hand goes towards the centre, 400 steps with the button down and 20 in which the force fades, and then back without a force.
// The ramp at the press loses as much as the fade adds, so the energy is that of the bound along 400 steps.
TEST(EffectStep, AnEffectWithAButtonGivesAtMostItsBoundTimesThePath) {
  constexpr double kBoundN = 1.25;
  constexpr double kStepM = 1e-4;
  constexpr int kHeldSteps = 400, kFadeSteps = 20;
  const SpringEffect spring = {.stiffness_n_per_m = 400, .max_force_n = kBoundN};
  EffectStep step({}, {{spring, EffectSwitch{.button = 1}}});
  Vec3 last(0.1, 0, 0);
  free_force(step, last, 0);
  for (int cycle = 0; cycle < 3; ++cycle) {
    double energy_to_hand_j = 0.0;
    const auto move_to = [&](int n, std::uint32_t buttons) {
      const Vec3 p(0.1 - kStepM * n, 0, 0);
      const Vec3 force_n = free_force(step, p, buttons);
      ASSERT_LE(force_n.norm(), kBoundN * (1 + 1e-12));
      energy_to_hand_j += force_n.dot(p - last);
      last = p;
    };
    for (int n = 1; n <= kHeldSteps + kFadeSteps; ++n) move_to(n, n <= kHeldSteps ? 1 : 0);
    for (int n = kHeldSteps + kFadeSteps - 1; n >= 0; --n) move_to(n, 0);
    EXPECT_LE(energy_to_hand_j, kBoundN * kStepM * (kHeldSteps + kFadeSteps)) << "cycle " << cycle;
    EXPECT_NEAR(energy_to_hand_j, kBoundN * kStepM * kHeldSteps, 1e-9 * kBoundN * kStepM * kHeldSteps) << "cycle " << cycle;
  }
}

TEST(EffectStep, ResetForgetsEverything) {
  EffectStep used({all_surface_effects()}, all_space_effects());
  EffectStep fresh({all_surface_effects()}, all_space_effects());
  for (const Vec3& p : paths::closed(5, 500, {0, 0, 0}, 0.01)) press(used, p);
  used.reset();
  for (const Vec3& p : paths::closed(6, 500, {0, 0, 0}, 0.01)) {
    const EffectResult a = press(used, p);
    const EffectResult b = press(fresh, p);
    ASSERT_EQ(a.force_n, b.force_n);
    ASSERT_EQ(a.p_SP, b.p_SP);
    ASSERT_EQ(a.is_felt, b.is_felt);
  }
}

TEST(EffectStep, ASampleThatIsNotFiniteChangesNothing) {
  EffectStep disturbed({all_surface_effects()}, all_space_effects());
  EffectStep quiet({all_surface_effects()}, all_space_effects());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  for (const Vec3& p : paths::closed(8, 300, {0, 0, 0}, 0.01)) {
    const EffectResult nothing = disturbed.step({nan, inf, 0}, kMs, {});
    ASSERT_EQ(nothing.force_n, Vec3::Zero());
    ASSERT_FALSE(nothing.is_felt);
    ASSERT_EQ(press(disturbed, p).force_n, press(quiet, p).force_n);
  }
}

// For any motion and any time step the force is finite, and not larger than the sum of all bounds.
TEST(EffectStep, IsFiniteAndBoundedForAnyInput) {
  constexpr std::uint64_t kSeed = 20;
  RecordProperty("seed", static_cast<int>(kSeed));
  std::mt19937_64 random(kSeed);
  const auto pick = [&](const std::vector<double>& from) { return from[random() % from.size()]; };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  const std::vector<double> lengths = {0.0, -0.0, 1e-9, -1e-3, 2e-3, -5e-3, 0.01, 1.0, -1e3, 1e150, -1e200, 1e308, 5e-324, nan, inf};
  const std::vector<double> times = {0.0, 1e-3, 1e-3, 1e-3, 1e-4, -1.0, 1e-300, 5e-324, 1.0, 1e300, nan, inf, -inf};
  SurfaceEffects needle;
  for (int i = 0; i < 8; ++i) needle.layers.add({.depth_m = 1e-3 * i, .stiffness_n_per_m = 1e6, .pop_force_n = 10, .drag_ns_per_m = 100});
  const std::vector<SurfaceEffects> surfaces = {all_surface_effects(), needle, SurfaceEffects()};
  EffectStep still(surfaces, all_space_effects());
  EffectStep moving(surfaces, all_space_effects(), {1, EffectStep::kStill, 0});
  double space_n = 0.0;
  for (const SwitchedEffect& effect : all_space_effects()) space_n += bound_of(effect.effect);
  const double slope_factor = std::sqrt(1.0 + all_surface_effects().bumps.slope() * all_surface_effects().bumps.slope());
  for (int k = 0; k < 200000; ++k) {
    EffectStep& step = k % 2 == 0 ? still : moving;
    if (k % 997 < 2) step.reset();
    const Vec3 p(pick(lengths), pick(lengths), pick(lengths));
    SurfaceContact contact = {.p_SP = p, .object = static_cast<int>(random() % 6) - 2};
    contact.contact = random() % 2 == 0;
    // What a method may give: a finite force, and a proxy anywhere.
    if (contact.contact) {
      contact.force_n = Vec3(0.1, -2, 3) * static_cast<double>(random() % 3);
      contact.p_SP = Vec3(pick(lengths), pick(lengths), pick(lengths));
    }
    std::array<Pose, 2> X_SF = {Pose::Identity(), Pose::Identity()};
    X_SF[0].linear() = Eigen::AngleAxisd(static_cast<double>(k % 100), Vec3::UnitX()).toRotationMatrix();
    for (Pose& pose : X_SF) pose.translation() = Vec3(pick(lengths), pick(lengths), pick(lengths));
    step.place(std::span(X_SF).first(random() % 3));
    const SurfacePlace place{.p_rest = Vec3(pick(lengths), 0, 0), .moved = Vec3(0, pick(lengths), 0)};
    if (random() % 4 == 0) contact.place = &place;
    const EffectResult result = step.step(p, pick(times), contact, static_cast<std::uint32_t>(random()));
    ASSERT_TRUE(result.force_n.allFinite()) << "step " << k << ", seed " << kSeed;
    const double surface_n = (contact.force_n.norm() + kMaxEffectForceN) * (1.0 + slope_factor) + all_surface_effects().tap.max_force_n +
                             all_surface_effects().snap.bound_n() + all_surface_effects().texture.bound_n();
    ASSERT_LE(result.force_n.norm(), (surface_n + space_n) * (1 + 1e-9)) << "step " << k << ", seed " << kSeed;
  }
}

TEST(EffectStep, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  EffectStep step({all_surface_effects()}, all_space_effects());
  const auto path = paths::closed(9, 2000, {0, 0, 0}, 0.01);
  const AllocationGuard guard;
  for (const Vec3& p : path) press(step, p);
  step.reset();
  EXPECT_EQ(guard.count(), 0U);
}

// The spring of friction keeps its direction when the contact goes from a surface in a turned frame to one that stands still.
TEST(EffectStep, FrictionGoesOnFromFrameToFrame) {
  const SurfaceEffects rough{.drag = {.friction = {0.5, 0.5}}};
  EffectStep step({rough, rough}, {}, {0, EffectStep::kStill});
  Pose X_SF = Pose::Identity();
  X_SF.linear() = Eigen::AngleAxisd(1.0, Vec3::UnitZ()).toRotationMatrix();
  const auto force_at = [&](double x_m, int object) {
    step.place({&X_SF, 1});
    const Vec3 p(x_m, 0.0, -2e-3);
    return step.step(p, kMs, on_plane(p, object)).force_n;
  };
  (void)force_at(0.0, 0);
  EXPECT_LT((force_at(5e-4, 0) - Vec3(-0.5, 0, 2)).norm(), 1e-12);
  EXPECT_LT((force_at(5e-4, 1) - Vec3(-0.5, 0, 2)).norm(), 1e-12) << "carried over";
  EXPECT_LT((force_at(7e-4, 1) - Vec3(-0.7, 0, 2)).norm(), 1e-12);
  EXPECT_LT((force_at(7e-4, 0) - Vec3(-0.7, 0, 2)).norm(), 1e-12) << "and back";
  X_SF.linear() = Eigen::AngleAxisd(1.2, Vec3::UnitZ()).toRotationMatrix();
  EXPECT_LT((force_at(7e-4, 0) - Vec3(-0.7, 0, 2)).norm(), 1e-12) << "turned about the point that sticks";
  X_SF.translation() = Vec3(0, 1e-4, 0);
  EXPECT_LT((force_at(7e-4, 0) - Vec3(-0.7, 0.1, 2)).norm(), 1e-12) << "it takes that point along";
}

// When another method takes over, its step goes on with the speed of the hand, also relative to moving surfaces.
TEST(EffectStep, ContinuesTheHandMotionOfAnotherStep) {
  const SurfaceEffects thick{.viscosity = {.damping_ns_per_m = 4}};
  const Pose X_SF = Pose::Identity();
  for (const int frame : {EffectStep::kStill, 0}) {
    EffectStep other({thick}, {}, {frame});
    EffectStep next({thick}, {}, {frame});
    const auto force_in_cycle = [&](EffectStep& step, int n) {
      step.place({&X_SF, 1});
      const Vec3 p(1e-4 * n, 0.0, -2e-3);
      return step.step(p, kMs, on_plane(p)).force_n;
    };
    for (int n = 0; n < 20; ++n) (void)force_in_cycle(other, n);
    (void)force_in_cycle(next, 19);
    next.continue_hand_motion(other);
    const Vec3 expected_n = force_in_cycle(other, 20);
    EXPECT_NEAR(expected_n.x(), -0.4, 1e-9) << frame;
    EXPECT_LT((force_in_cycle(next, 20) - expected_n).norm(), 1e-12) << frame;
  }
}

// When the scene is moved, dampers, friction and the frames of moving surfaces go on as if the hand rested.
TEST(EffectStep, ASceneThatIsMovedIsNoMotionOfTheHand) {
  const SurfaceEffects rough{.drag = {.friction = {0.5, 0.5}}};
  const SurfaceEffects thick{.viscosity = {.damping_ns_per_m = 4}};
  const Pose X_SF = Pose::Identity();
  const Vec3 p(0.0, 0.0, -2e-3);
  const Vec3 moved = p + Vec3(5e-4, 0.0, 0.0);
  for (const bool is_noted : {true, false}) {
    for (const SurfaceEffects& surface : {rough, thick}) {
      for (const int frame : {EffectStep::kStill, 0}) {
        EffectStep step({surface}, {}, {frame});
        const auto force_at = [&](const Vec3& at) {
          step.place({&X_SF, 1});
          return step.step(at, kMs, on_plane(at)).force_n;
        };
        for (int n = 0; n < 20; ++n) (void)force_at(p);
        if (is_noted) step.note_scene_moved(moved);
        const double sideways_n = force_at(moved).head<2>().norm();
        if (is_noted) {
          EXPECT_LT(sideways_n, 1e-12) << frame;
        } else {
          EXPECT_GT(sideways_n, 0.1) << frame;
        }
      }
    }
    EffectStep space({}, {ViscousEffect{}});
    for (int n = 0; n < 20; ++n) (void)space.step_in_space(p, kMs);
    if (is_noted) space.note_scene_moved(moved);
    EXPECT_EQ(space.step_in_space(moved, kMs).isZero(1e-12), is_noted);
  }
}

// The force is that of free space, even where the surface held the device before: a tool took the place of that surface.
TEST(EffectStep, StepInSpaceIgnoresSurfaces) {
  EffectStep tool({all_surface_effects()}, all_space_effects());
  EffectStep probe({SurfaceEffects()}, all_space_effects());
  EffectStep snapping({all_surface_effects()}, all_space_effects());
  for (EffectStep* step : {&tool, &probe, &snapping}) (void)step->step({0.0, 0.0, -0.001}, kMs, on_plane({0.0, 0.0, -0.001}));
  double largest_snap_n = 0.0;
  for (int n = 0; n < 400; ++n) {
    const Vec3 p(1e-4 * n, 0.002 * std::sin(0.1 * n), 0.0005);
    const std::uint32_t buttons = n / 50 % 4;
    const Vec3 probe_force_n = probe.step(p, kMs, {}, buttons).force_n;
    ASSERT_EQ(tool.step_in_space(p, kMs, buttons), probe_force_n) << n;
    largest_snap_n = std::max(largest_snap_n, (snapping.step(p, kMs, {}, buttons).force_n - probe_force_n).norm());
  }
  EXPECT_GT(largest_snap_n, 0.01) << "the surface snaps, unless a tool is held";
}

}  // namespace
}  // namespace hapton
