// Effects of surfaces that move or deform (EffectFrames, SurfaceFrame, ForceMethod::find_place), as TouchStep computes them: their force is
// that of a static surface under the motion of the hand relative to the surface.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/force/touch_step.h"
#include "tests/core/force/made_effects.h"
#include "tests/core/force/moving_plates.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr double kMs = 1e-3;

TouchObject made_plate(const NamedEffects& effects) {
  TouchObject plate = plate_object({-0.15, -0.15, -0.02}, {0.15, 0.15, 0.0});
  plate.effects = effects.make(*plate.mesh);
  return plate;
}

TouchStep make_touch_over(const TouchScene& scene, const char* method = "proxy") {
  auto made = make_method({.name = method}, scene);
  EXPECT_TRUE(made) << (made ? "" : made.error().what);
  return {std::move(*made), scene};
}

// Shifts at 0.2 m/s and turns at 2 rad/s, from the rest pose.
std::shared_ptr<const KeyframeMotion> fast_motion() {
  const Quat turn(Eigen::AngleAxisd(1.6, Vec3(2, 1, -2) / 3.0));
  return std::make_shared<const KeyframeMotion>(
      Vec3(0.01, 0.02, 0.0), std::vector<Keyframe>{{0.0, {0.01, 0.02, 0.0}, Quat::Identity()}, {0.8, {0.106, 0.02, 0.128}, turn}}, false);
}

// Taps the plate z = 0, slides with changing depth, leaves it by less than the range of a snap, and comes again.
Vec3 hand_on_plate(int i) {
  const double t = kMs * i;
  return {0.02 * std::sin(9.0 * t) + 0.01 * t, 0.015 * std::cos(7.0 * t), 0.004 * std::cos(17.0 * t) - 0.0028};
}

struct TwinComparison {
  double difference_n = 0.0;  // largest difference of the forces on the two objects
  double most_n = 0.0;        // largest force
  double effect_n = 0.0;      // largest difference from the force without effects
  int contact_steps = 0;
  int other_field_steps = 0;  // steps in which another field of the output differs
};

// Compares a moving object with one that stands still; `path` is in the object's frame. is_commanded: a command moves it, not keyframes.
TwinComparison compare(const NamedEffects& effects, const char* method, const std::function<Vec3(int)>& path, bool is_commanded) {
  TouchScene still{.objects = {made_plate(effects)}};
  TouchScene moving = still;
  const auto motion = fast_motion();
  if (is_commanded) {
    moving.objects[0].command_pivot = motion->pivot();
  } else {
    moving.objects[0].motion = motion;
  }
  TouchScene without_effects = still;
  without_effects.objects[0].effects = {};
  TouchStep still_touch = make_touch_over(still, method);
  TouchStep moving_touch = make_touch_over(moving, method);
  TouchStep bare_touch = make_touch_over(without_effects, method);
  if (is_commanded) {
    EXPECT_TRUE(moving_touch.command(0, {.serial = 1, .from = motion->keyframes()[0], .to = motion->keyframes()[1]}));
  }
  TwinComparison twin;
  for (int i = 0; i < 800; ++i) {
    const double time_s = kMs * i;
    const Pose X_SO = motion->pose_at(time_s);
    const TouchOutput expected = still_touch.step({.p_WD = path(i), .dt_s = kMs, .time_s = time_s});
    const TouchOutput felt = moving_touch.step({.p_WD = X_SO * path(i), .dt_s = kMs, .time_s = time_s});
    const TouchOutput bare = bare_touch.step({.p_WD = path(i), .dt_s = kMs, .time_s = time_s});
    twin.difference_n = std::max(twin.difference_n, (X_SO.linear().transpose() * felt.force_n - expected.force_n).norm());
    twin.most_n = std::max(twin.most_n, expected.force_n.norm());
    twin.effect_n = std::max(twin.effect_n, (expected.force_n - bare.force_n).norm());
    twin.contact_steps += expected.contact ? 1 : 0;
    const double offset_m = (X_SO.linear().transpose() * felt.visual_offset_m - expected.visual_offset_m).norm();
    twin.other_field_steps += expected.contact != felt.contact || expected.object != felt.object || offset_m > 1e-12 ? 1 : 0;
  }
  return twin;
}

class MovingEffects : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Methods, MovingEffects, testing::Values("proxy", "reference"), [](const auto& given) { return given.param; });

// Relative to the moving object, whatever its motion, the hand moves as over the object that stands still.
TEST_P(MovingEffects, AreThoseOfAStaticObjectInItsFrame) {
  for (const NamedEffects& effects : all_effects()) {
    for (const bool is_commanded : {false, true}) {
      const TwinComparison twin = compare(effects, GetParam(), hand_on_plate, is_commanded);
      EXPECT_LT(twin.difference_n, 1e-9 * twin.most_n) << effects.name;
      EXPECT_EQ(twin.other_field_steps, 0) << effects.name;
      EXPECT_GT(twin.contact_steps, 300) << effects.name;
      EXPECT_GT(twin.effect_n, 0.1) << effects.name << " is not felt";
    }
  }
}

// A hand that rests on the moving object feels what it feels resting on a static one.
TEST_P(MovingEffects, OfAHandThatMovesAlongAreThoseAtRest) {
  const auto resting = [](int i) { return Vec3(0.013, -0.007, i < 40 ? 0.002 - 1e-4 * i : -0.002); };
  for (const NamedEffects& effects : all_effects()) {
    const TwinComparison twin = compare(effects, GetParam(), resting, false);
    EXPECT_LT(twin.difference_n, 1e-9 * twin.most_n) << effects.name;
    EXPECT_EQ(twin.other_field_steps, 0) << effects.name;
  }
}

// The hand holds still in the scene: relative to the object it moves the opposite way.
TEST_P(MovingEffects, OfAHandAtRestAreThoseOfTheOppositeMotion) {
  const auto motion = fast_motion();
  // At a third of the motion (0.27 s) the hand is 2 mm deep.
  const Vec3 p_S = motion->pose_at(0.27) * Vec3(0.02, 0.01, -0.002);
  const auto at_rest = [&](int i) -> Vec3 { return motion->pose_at(kMs * i).inverse(Eigen::Isometry) * p_S; };
  int acting_effects = 0;
  for (const NamedEffects& effects : all_effects()) {
    const TwinComparison twin = compare(effects, GetParam(), at_rest, false);
    EXPECT_LT(twin.difference_n, 1e-9 * std::max(1.0, twin.most_n)) << effects.name;
    EXPECT_EQ(twin.other_field_steps, 0) << effects.name;
    EXPECT_GT(twin.contact_steps, 10) << effects.name;
    acting_effects += twin.effect_n > 0.05 ? 1 : 0;
  }
  EXPECT_GE(acting_effects, 10);
}

// No time passes, so the moving object stays at its rest pose.
TEST_P(MovingEffects, AtTheFirstPoseAreThoseOfAStaticObjectToTheBit) {
  for (const NamedEffects& effects : all_effects()) {
    const TouchScene still{.objects = {made_plate(effects)}};
    TouchScene moving = still;
    moving.objects[0].motion = fast_motion();
    TouchStep a = make_touch_over(still, GetParam());
    TouchStep b = make_touch_over(moving, GetParam());
    for (int i = 0; i < 400; ++i) {
      const Vec3 p = hand_on_plate(i);
      const TouchOutput here = a.step({.p_WD = p, .dt_s = kMs});
      const TouchOutput there = b.step({.p_WD = p, .dt_s = kMs});
      ASSERT_EQ(here.force_n, there.force_n) << effects.name << " " << i;
      ASSERT_EQ(here.visual_offset_m, there.visual_offset_m) << effects.name << " " << i;
    }
  }
}

TEST_P(MovingEffects, UseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  for (const NamedEffects& effects : all_effects()) {
    TouchScene scene{.objects = {made_plate(effects)}};
    const auto motion = fast_motion();
    scene.objects[0].motion = motion;
    TouchStep touch = make_touch_over(scene, GetParam());
    (void)touch.step({.p_WD = hand_on_plate(0), .dt_s = kMs});
    const AllocationGuard guard;
    for (int i = 1; i < 300; ++i) {
      const double time_s = kMs * i;
      (void)touch.step({.p_WD = motion->pose_at(time_s) * hand_on_plate(i), .dt_s = kMs, .time_s = time_s});
    }
    EXPECT_EQ(guard.count(), 0U) << effects.name;
  }
}

// Closed forms, for a hand that holds still 2 mm below the surface of a plate that passes at 0.1 m/s.
TEST(MovingEffectsOfAStep, AreAsTheirFormulasSay) {
  const Vec3 v(0.1, 0.0, 0.0);
  const Vec3 p(0.01, 0.02, -0.002);
  const auto felt_at = [&](const SurfaceEffects& effects, int steps, Vec3 from = Vec3::Zero()) {
    TouchScene scene{.objects = {plate_object({-0.15, -0.15, -0.02}, {0.15, 0.15, 0.0}, shift_motion(from, from + v, 1.0))}};
    scene.objects[0].effects = effects;
    TouchStep touch = make_touch_over(scene);
    TouchOutput felt;
    touch.reset({.p_WD = {p.x(), p.y(), 0.004}});
    for (int i = 0; i <= steps; ++i) {
      felt = touch.step({.p_WD = {p.x(), p.y(), std::max(p.z(), 0.002 - 1e-3 * i)}, .dt_s = kMs, .time_s = kMs * i});
    }
    return felt.force_n;
  };
  const Vec3 spring(0.0, 0.0, 1000.0 * 0.002);
  EXPECT_LT((felt_at({.viscosity = {.damping_ns_per_m = 5.0}}, 100) - (spring + 5.0 * v)).norm(), 1e-6) << "it takes the hand along";
  const SurfaceBumps ridges{.pattern = SurfaceBumps::Pattern::ridges, .height_m = 5e-4, .length_m = 4e-3};
  for (const int steps : {20, 50, 73, 100}) {
    const double phase = 2.0 * std::numbers::pi / 4e-3 * (p.x() - 0.1 * kMs * steps);
    const double pressed_m = 0.002 - 0.5 * 5e-4 * (1.0 - std::cos(phase));
    const double slope = -0.5 * 5e-4 * 2.0 * std::numbers::pi / 4e-3 * std::sin(phase);
    EXPECT_LT((felt_at({.bumps = ridges}, steps) - 1000.0 * pressed_m * Vec3(-slope, 0.0, 1.0)).norm(), 1e-6) << steps;
  }
  // Progressive stiffness depends on the depth alone.
  EXPECT_LT((felt_at({.progressive = {.n_per_m2 = 1e5}}, 60) - (spring + Vec3(0, 0, 1e5 * 4e-6))).norm(), 1e-6);
}

// A plate that rises at 0.2 m/s taps a hand that holds still.
TEST(MovingEffectsOfAStep, ASurfaceTapsTheHand) {
  const TapVibration metal{.ns_per_m = 5.0, .frequency_hz = 100.0, .decay_s = 0.02};
  TouchScene scene{.objects = {plate_object({-0.1, -0.1, -0.02}, {0.1, 0.1, 0.0}, shift_motion(Vec3::Zero(), {0.0, 0.0, 0.1}, 0.5),
                                            {.stiffness_n_per_m = 100.0})}};
  scene.objects[0].effects.tap = metal;
  TouchStep touch = make_touch_over(scene);
  int steps_since_contact = -1;
  for (int i = 0; i < 60; ++i) {
    const TouchOutput felt = touch.step({.p_WD = {0.01, 0.0, 0.00205}, .dt_s = kMs, .time_s = kMs * i});
    const double depth_m = 0.2 * kMs * i - 0.00205;
    if (depth_m < 0.0) continue;
    ++steps_since_contact;
    const double t = kMs * steps_since_contact;
    const double ring_n = 5.0 * 0.2 * std::exp(-t / 0.02) * std::sin(2.0 * std::numbers::pi * 100.0 * t);
    EXPECT_NEAR(felt.force_n.z(), 100.0 * depth_m + ring_n, 1e-6) << i;
  }
  EXPECT_GT(steps_since_contact, 40);
}

// The plate has touched the hand, and goes down again: it pulls the hand until the hand is out of the range of the snap.
TEST(MovingEffectsOfAStep, ASurfaceThatLeavesPullsTheHandWithinTheRangeOfASnap) {
  const auto motion = std::make_shared<const KeyframeMotion>(
      Vec3::Zero(),
      std::vector<Keyframe>{
          {0.0, Vec3::Zero(), Quat::Identity()}, {0.1, {0, 0, 0.01}, Quat::Identity()}, {0.2, Vec3::Zero(), Quat::Identity()}},
      false);
  TouchScene scene{.objects = {plate_object({-0.1, -0.1, -0.02}, {0.1, 0.1, 0.0}, motion)}};
  scene.objects[0].effects.snap = {.stiffness_n_per_m = 300.0, .range_m = 2e-3};
  TouchStep touch = make_touch_over(scene);
  int pulls = 0;
  for (int i = 0; i < 200; ++i) {
    const TouchOutput felt = touch.step({.p_WD = {0.01, 0.0, 0.00805}, .dt_s = kMs, .time_s = kMs * i});
    const double height_m = 0.00805 - motion->pose_at(kMs * i).translation().z();
    const bool is_after = i > 100 && height_m > 0.0 && height_m <= 2e-3;
    if (height_m > 0.0) {
      EXPECT_NEAR(felt.force_n.z(), is_after ? -300.0 * height_m : 0.0, 1e-6) << i;
    }
    pulls += is_after ? 1 : 0;
  }
  EXPECT_EQ(pulls, 20);
}

// A pose that jumps gives no velocity; a hand that slides goes on as if nothing had happened.
TEST(MovingEffectsOfAStep, AJumpOfThePoseIsNoVelocity) {
  for (const NamedEffects& effects : all_effects()) {
    const std::string name = effects.name;
    if (name == "layers" || name == "grid" || name == "ridges" || name.ends_with("map")) continue;  // they depend on the place
    TouchScene scene{.objects = {made_plate(effects)}};
    TouchScene still = scene;
    scene.objects[0].command_pivot = Vec3::Zero();
    TouchStep touch = make_touch_over(scene);
    TouchStep on_still = make_touch_over(still);
    for (int i = 0; i < 100; ++i) {
      if (i == 50) {
        const Keyframe to{.time_s = kMs * 49.5, .p_S = {0.006, -0.003, 0.0}};
        ASSERT_TRUE(touch.command(0, {.serial = 1, .from = {.time_s = kMs * 49.5}, .to = to}));
      }
      const Vec3 p(0.01 + 1e-5 * i, 0.0, std::max(-0.002, 0.002 - 5e-4 * i));
      const TouchOutput a = touch.step({.p_WD = p, .dt_s = kMs, .time_s = kMs * i});
      const TouchOutput b = on_still.step({.p_WD = p, .dt_s = kMs, .time_s = kMs * i});
      EXPECT_LT((a.force_n - b.force_n).norm(), 1e-9) << name << " " << i;
    }
  }
}

TEST(MovingEffectsOfAStep, AJumpEndsASnap) {
  TouchScene scene{.objects = {plate_object({-0.1, -0.1, -0.02}, {0.1, 0.1, 0.0})}};
  scene.objects[0].effects.snap = {.stiffness_n_per_m = 300.0, .range_m = 2e-3};
  scene.objects[0].command_pivot = Vec3::Zero();
  TouchStep touch = make_touch_over(scene);
  for (int i = 0; i < 40; ++i) {
    if (i == 30) {
      ASSERT_TRUE(touch.command(0, {.serial = 1, .from = {.time_s = kMs * 29.5}, .to = {.time_s = kMs * 29.5, .p_S = {0.0015, 0, 0}}}));
    }
    const Vec3 p(0.0, 0.0, i < 10 ? 0.001 : i < 20 ? -0.001 : 0.0005);
    const double force_n = touch.step({.p_WD = p, .dt_s = kMs, .time_s = kMs * i}).force_n.z();
    if (i >= 20) {
      EXPECT_NEAR(force_n, i < 30 ? -0.15 : 0.0, 1e-6) << i;
    }
  }
}

// Two plates side by side, one moving and one not, both viscous: the hand goes from one to the other, and the velocity is relative to the
// touched plate.
TEST(MovingEffectsOfAStep, OnAnotherObjectTheVelocityIsRelativeToThatObject) {
  const Vec3 v(0.0, 0.1, 0.0);
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.1, -0.2, -0.02}, {0.0, 0.2, 0.0}, shift_motion(Vec3::Zero(), v, 1.0)));
  scene.objects.push_back(plate_object({0.0, -0.2, -0.02}, {0.1, 0.2, 0.0}));
  scene.objects.push_back(plate_object({-0.1, -0.2, -0.5}, {0.1, 0.2, -0.4}, shift_motion(Vec3::Zero(), -v, 1.0)));
  for (TouchObject& object : scene.objects) object.effects.viscosity.damping_ns_per_m = 4.0;
  TouchStep touch = make_touch_over(scene);
  int on_moving = 0;
  int on_still = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 hand_velocity(0.05, 0.0, 0.0);  // m/s
    Vec3 p = Vec3(-0.01, 0.0, i < 4 ? 0.002 - 1e-3 * i : -0.002) + kMs * i * hand_velocity;
    if (std::abs(p.x()) < 1e-3) p.z() = 0.001;  // over the joint between their side walls
    const TouchOutput felt = touch.step({.p_WD = p, .dt_s = kMs, .time_s = kMs * i});
    if (i < 20 || std::abs(p.x()) < 1e-3) continue;
    const Vec3 expected = Vec3(0, 0, 2.0) - 4.0 * (p.x() < 0.0 ? Vec3(hand_velocity - v) : hand_velocity);
    EXPECT_LT((felt.force_n - expected).norm(), 1e-6) << i;
    EXPECT_EQ(felt.object, p.x() < 0.0 ? 0 : 1);
    (p.x() < 0.0 ? on_moving : on_still) += 1;
  }
  EXPECT_GT(on_moving, 100);
  EXPECT_GT(on_still, 100);
}

// The view transform shifts the scene under a hand that rests in the world, while an object of the scene moves.
TEST(MovingEffectsOfAStep, AShiftOfTheSceneIsNoVelocity) {
  TouchScene scene{.objects = {plate_object({-0.1, -0.1, -0.02}, {0.1, 0.1, 0.0}, shift_motion(Vec3::Zero(), {0.1, 0.0, 0.0}, 1.0))}};
  scene.objects[0].effects.viscosity.damping_ns_per_m = 4.0;
  TouchStep touch = make_touch_over(scene);
  Pose X_WS = Pose::Identity();
  for (int i = 0; i < 60; ++i) {
    if (i == 30) X_WS.translation() = Vec3(0.02, 0.01, 0.0);
    const TouchOutput felt = touch.step({.p_WD = {0.0, 0.0, i == 0 ? 0.002 : -0.002}, .X_WS = X_WS, .dt_s = kMs, .time_s = kMs * i});
    if (i > 10) {
      EXPECT_LT((felt.force_n - Vec3(0.4, 0.0, 2.0)).norm(), 1e-6) << i;
    }
  }
}

// A sheet deforms by a shift of all vertices, as if it moved; with and without a motion of the object in addition.
TEST(DeformingEffects, OfAShiftAreThoseOfAMovingObject) {
  const Vec3 shift(0.08, -0.04, 0.1);  // in 0.8 s
  std::vector<std::pair<NamedEffects, bool>> cases;
  for (const NamedEffects& effects : all_effects()) {
    for (const bool moves : {false, true}) cases.emplace_back(effects, moves);
  }
  for (const auto& [effects, moves] : cases) {
    if (std::string(effects.name) == "snap") continue;  // scene files reject it
    TouchObject sheet{.mesh = made::shared(made::sheet(0.15, 0.0, 8)), .material = {}};
    sheet.effects = effects.make(*sheet.mesh);
    const TouchScene still{.objects = {sheet}};
    TouchScene deforming = still;
    MorphTarget target;
    for (std::uint32_t n = 0; n < sheet.mesh->vertices.size(); ++n) {
      target.vertices.push_back(n);
      target.displacements.push_back(shift);
    }
    deforming.objects[0].deformation =
        std::make_shared<const MeshDeformation>(std::vector{target}, std::vector<MorphKey>{{0.0, {0.0}}, {0.8, {1.0}}}, false);
    const auto motion = fast_motion();
    if (moves) deforming.objects[0].motion = motion;
    TouchStep still_touch = make_touch_over(still);
    TouchStep deforming_touch = make_touch_over(deforming);
    double difference_n = 0.0;
    double most_n = 0.0;
    for (int i = 0; i < 800; ++i) {
      const double time_s = kMs * i;
      const Vec3 p = hand_on_plate(i);
      const Vec3 on_still = still_touch.step({.p_WD = p, .dt_s = kMs, .time_s = time_s}).force_n;
      const Pose X_SO = moves ? motion->pose_at(time_s) : Pose::Identity();
      const Vec3 on_deforming =
          deforming_touch.step({.p_WD = X_SO * Vec3(p + shift * time_s / 0.8), .dt_s = kMs, .time_s = time_s}).force_n;
      difference_n = std::max(difference_n, (X_SO.linear() * on_still - on_deforming).norm());
      most_n = std::max(most_n, on_still.norm());
    }
    EXPECT_LT(difference_n, 1e-6 * most_n) << effects.name;
  }
}

// A sheet that is stretched along x by 1 + t / 2, under a hand that holds still: ridges are stretched with it, and the surface slides past
// the hand at the speed of the touched point.
TEST(DeformingEffects, OfAStretchedSheetAreAsTheirFormulasSay) {
  const auto felt_at = [](const SurfaceEffects& effects, double time_s) {
    TouchObject sheet{.mesh = made::shared(made::sheet(0.1, 0.0, 8)), .material = {}, .effects = effects};
    MorphTarget target;
    for (std::uint32_t n = 0; n < sheet.mesh->vertices.size(); ++n) {
      target.vertices.push_back(n);
      target.displacements.emplace_back(sheet.mesh->vertices[n].x(), 0.0, 0.0);
    }
    sheet.deformation =
        std::make_shared<const MeshDeformation>(std::vector{target}, std::vector<MorphKey>{{0.0, {0.0}}, {2.0, {1.0}}}, false);
    TouchStep touch = make_touch_over({.objects = {sheet}});
    TouchOutput felt;
    for (int i = 0; i <= std::lround(time_s / kMs); ++i) {
      felt = touch.step({.p_WD = {0.04, 0.01, std::max(-0.002, 0.002 - 1e-3 * i)}, .dt_s = kMs, .time_s = kMs * i});
    }
    return felt.force_n;
  };
  const SurfaceBumps ridges{.pattern = SurfaceBumps::Pattern::ridges, .height_m = 5e-4, .length_m = 4e-3};
  for (const double time_s : {0.05, 0.2, 0.41}) {
    const double stretch = 1.0 + 0.5 * time_s;
    const double at_rest = 0.04 / stretch;
    const double phase = 2.0 * std::numbers::pi / 4e-3 * at_rest;
    const double pressed_m = 0.002 - 0.5 * 5e-4 * (1.0 - std::cos(phase));
    const double slope = -0.5 * 5e-4 * 2.0 * std::numbers::pi / 4e-3 * std::sin(phase) / stretch;
    EXPECT_LT((felt_at({.bumps = ridges}, time_s) - 1000.0 * pressed_m * Vec3(-slope, 0.0, 1.0)).norm(), 1e-5) << time_s;
    const double speed = 0.5 * at_rest;  // mean over the last samples: it changes by less than 1 % in them
    EXPECT_LT((felt_at({.viscosity = {.damping_ns_per_m = 5.0}}, time_s) - Vec3(5.0 * speed, 0.0, 2.0)).norm(), 1e-3) << time_s;
  }
}

TEST(DeformingEffects, OfARisingSheetTapTheHand) {
  TouchObject sheet{.mesh = made::shared(made::sheet(0.1, 0.0, 8)), .material = {.stiffness_n_per_m = 100.0}};
  sheet.effects.tap = {.ns_per_m = 5.0, .frequency_hz = 100.0, .decay_s = 0.02};
  MorphTarget target;
  for (std::uint32_t n = 0; n < sheet.mesh->vertices.size(); ++n) {
    target.vertices.push_back(n);
    target.displacements.emplace_back(0.0, 0.0, 0.1);
  }
  sheet.deformation =
      std::make_shared<const MeshDeformation>(std::vector{target}, std::vector<MorphKey>{{0.0, {0.0}}, {0.5, {1.0}}}, false);
  TouchStep touch = make_touch_over({.objects = {sheet}});
  int steps_since_contact = -1;
  for (int i = 0; i < 60; ++i) {
    const TouchOutput felt = touch.step({.p_WD = {0.013, 0.007, 0.00205}, .dt_s = kMs, .time_s = kMs * i});
    const double depth_m = 0.2 * kMs * i - 0.00205;
    if (depth_m < 0.0) continue;
    ++steps_since_contact;
    const double t = kMs * steps_since_contact;
    const double ring_n = 5.0 * 0.2 * std::exp(-t / 0.02) * std::sin(2.0 * std::numbers::pi * 100.0 * t);
    EXPECT_NEAR(felt.force_n.z(), 100.0 * depth_m + ring_n, 1e-6) << i;
  }
  EXPECT_GT(steps_since_contact, 40);
}

}  // namespace
}  // namespace hapton
