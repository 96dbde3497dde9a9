#include "core/force/moving_method.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/force/touch_step.h"
#include "tests/core/force/moving_plates.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

// A plate moves sideways at 0.1 m/s under a hand at rest. Without friction it slides along under the proxy; with friction it carries the
// proxy until the spring pulls as hard as friction holds.
TEST(MovingMethod, CarriesTheProxyAlongByFriction) {
  for (const double friction : {0.0, 0.8}) {
    TouchScene scene;
    scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0.02, 0, 0}, 0.2),
                                         {.friction_static = friction, .friction_dynamic = friction}));
    const auto method = make_method_for(scene);
    ASSERT_TRUE(method);
    method->reset({0, 0, 0.001});
    const Vec3 hand(0, 0, -0.003);  // 3 N: friction holds 2.4 N, so the proxy lags by 2.4 mm at most
    MethodOutput felt;
    for (int i = 0; i <= 200; ++i) felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
    EXPECT_NEAR(felt.force_n.z(), 3.0, 1e-3);
    EXPECT_NEAR(felt.force_n.x(), friction * 3.0, 1e-2) << "friction " << friction;
  }
}

TEST(MovingMethod, DampsTheMotionOfAnApproachingSurface) {
  TouchScene scene;
  scene.objects.push_back(
      plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.02}, 0.1), {.damping_ns_per_m = 2.0}));
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  const Vec3 hand(0, 0, 0.005);
  method->reset(hand);
  MethodOutput felt;
  for (int i = 0; i <= 50; ++i) felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
  // 10 mm up, 5 mm beyond the hand, at 0.2 m/s: 5 N, and 0.4 N of damping.
  EXPECT_NEAR(felt.force_n.z(), 5.4, 1e-3);
}

// A wall moves along a floor towards a hand that presses deeper (1 mm) than the wall's lower edge (0.5 mm): only the proxy, on the floor,
// is in the wall's way.
TEST(MovingMethod, FeelsTwoObjectsAtARightAngleWithOneProxy) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}));
  scene.objects.push_back(plate_object({0.010, -0.05, -0.0005}, {0.02, 0.05, 0.05}, shift_motion(Vec3::Zero(), {-0.008, 0, 0}, 0.1)));
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  method->reset({0.004, 0, 0.002});
  const Vec3 hand(0.004, 0, -0.001);
  MethodOutput felt;
  for (int i = 0; i <= 100; ++i) {
    felt = method->step({.p_SD = hand, .dt_s = 1e-3, .time_s = 1e-3 * i});
    const double wall = 0.010 - 0.08e-3 * i;
    ASSERT_NEAR(felt.force_n.x(), -kPlateStiffness * std::max(0.0, 0.004 - wall), 1e-3) << i;
    ASSERT_NEAR(felt.force_n.z(), 1.0, 1e-3) << i;
  }
  EXPECT_LT((felt.p_SP - Vec3(0.002, 0, 0)).norm(), 1e-6);
  EXPECT_EQ(felt.object, 1) << "the wall pushes more: 2 N, the floor 1 N";
}

// A soft floor and a hard wall that may be movable or not: the object with the larger share of the force is named, and its effects felt.
TEST(MovingMethod, NamesTheObjectThatPushesMoreAsOneSurfaceDoes) {
  TouchScene still;
  still.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, nullptr, {.stiffness_n_per_m = 300.0}));
  still.objects.push_back(plate_object({0.010, -0.04, -0.005}, {0.02, 0.04, 0.05}, nullptr, {.stiffness_n_per_m = 2000.0}));
  TouchScene movable = still;
  movable.objects[1].command_pivot = Vec3::Zero();
  for (const auto& [into_floor, into_wall, object] : {std::tuple(0.003, 0.001, 0), std::tuple(0.001, 0.003, 1)}) {
    for (const TouchScene* scene : {&still, &movable}) {
      const auto method = make_method_for(*scene);
      ASSERT_TRUE(method);
      method->reset({0.005, 0.001, 0.002});
      (void)method->step({.p_SD = {0.009, 0.001, 0.002}});
      MethodOutput felt;
      for (int i = 0; i < 5; ++i) felt = method->step({.p_SD = {0.010 + into_wall, 0.001, -into_floor}});
      const double stiffness = (300.0 * into_floor + 2000.0 * into_wall) / (into_floor + into_wall);
      EXPECT_LT((felt.force_n - stiffness * Vec3(-into_wall, 0, into_floor)).norm(), 1e-3);
      EXPECT_EQ(felt.object, object) << (scene == &movable ? "movable" : "still");
    }
  }
}

// A block comes down upon a hand that lies on the floor: it holds the hand down, and never presses it into the floor.
TEST(MovingMethod, NeverPressesTheHandIntoWhatStandsStill) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}));
  scene.objects.push_back(plate_object({-0.03, -0.03, 0.004}, {0.03, 0.03, 0.02}, shift_motion(Vec3::Zero(), {0, 0, -0.009}, 0.1)));
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  method->reset({0, 0, 0.001});
  MethodOutput felt;
  for (int i = 0; i <= 100; ++i) {
    felt = method->step({.p_SD = {0, 0, -0.001}, .dt_s = 1e-3, .time_s = 1e-3 * i});
    ASSERT_NEAR(felt.force_n.z(), 1.0, 1e-3) << "the floor's, whatever comes from above, at " << i << " ms";
    ASSERT_GE(felt.p_SP.z(), 0.0) << i;
  }
  // Lifted, it is held between them; in the end the block is 5 mm down in the floor.
  EXPECT_NEAR(method->step({.p_SD = {0, 0, 0.002}, .dt_s = 1e-3, .time_s = 0.1}).force_n.z(), -2.0, 1e-3);
}

// Random boxes move and turn about a moving hand. No step has the probe within the box or within another one that stands still. Where both
// hold the probe, there may be no room for it between them: it is then kept out of the box that stands still alone (CommonProxy).
TEST(MovingMethod, NoStepHasTheProbeWithinABody) {
  const std::uint64_t seed = 20261124;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto random_vector = [&](double most) { return Vec3(most * unit(random), most * unit(random), most * unit(random)); };
  int contact_steps = 0;
  int moving_contact_steps = 0;  // in which the box that stands still does not hold the probe
  for (int run = 0; run < 60; ++run) {
    const bool has_still_box = run % 2 == 1;
    const double rate_hz = std::array{250.0, 1000.0, 4000.0}[static_cast<std::size_t>(run % 3)];
    const Vec3 half_size = Vec3::Constant(0.012) + random_vector(0.008);
    const Vec3 centre = random_vector(0.01);
    std::vector<Keyframe> keyframes;
    Vec3 place = centre + 0.05 * random_vector(1.0).normalized();
    Quat turn(Eigen::AngleAxisd(unit(random), random_vector(1.0).normalized()));
    for (int k = 0; k < 6; ++k) {
      keyframes.push_back({0.2 * k, place, turn});
      place = 0.02 * random_vector(1.0).normalized();  // where the hand is
      turn = turn * Quat(Eigen::AngleAxisd(0.9 * unit(random), random_vector(1.0).normalized()));
    }
    const auto motion = std::make_shared<const KeyframeMotion>(centre, keyframes, false);
    TouchScene scene;
    scene.objects.push_back(
        plate_object(centre - half_size, centre + half_size, motion, {.friction_static = 0.3, .friction_dynamic = 0.2}));
    const Vec3 low(-0.03, -0.03, -0.04);
    const Vec3 high(0.03, 0.03, -0.015);
    if (has_still_box) scene.objects.push_back(plate_object(low, high));
    const double radius = run % 4 < 2 ? 0.0 : 0.003;
    const auto method = make_method_for(scene, {.probe_radius_m = radius});
    ASSERT_TRUE(method);
    const double tolerance = 1e-6;  // a few contact offsets
    const Vec3 margin = Vec3::Constant(2.0 * tolerance);
    const auto is_within = [&](const Vec3& p, const Vec3& from, const Vec3& to) {
      if (radius > 0.0) return (from - p).cwiseMax(p - to).cwiseMax(0.0).norm() < radius - tolerance;
      return ((p - from).array() > tolerance).all() && ((to - p).array() > tolerance).all();
    };
    Vec3 hand(0, 0, 0.02);
    Vec3 velocity = Vec3::Zero();
    bool is_first = true;
    for (int i = 0; i < static_cast<int>(rate_hz); ++i) {
      const double time = i / rate_hz;
      velocity = 0.999 * velocity + random_vector(0.01) - 0.02 * hand;
      hand += velocity / rate_hz;
      const Vec3 in_body = motion->pose_at(time).inverse(Eigen::Isometry) * hand;
      if (is_first && is_within(in_body, centre - half_size, centre + half_size)) continue;
      if (is_first) method->reset(hand);
      is_first = false;
      const MethodOutput felt = method->step({.p_SD = hand, .dt_s = 1.0 / rate_hz, .time_s = time});
      contact_steps += felt.contact ? 1 : 0;
      const Vec3 probe = motion->pose_at(time).inverse(Eigen::Isometry) * felt.p_SP;
      ASSERT_TRUE(felt.force_n.allFinite());
      if (has_still_box) {
        ASSERT_FALSE(is_within(felt.p_SP, low, high)) << "run " << run << " step " << i;
        if (is_within(felt.p_SP, low - margin, high + margin)) continue;
      }
      ASSERT_FALSE(is_within(probe, centre - half_size, centre + half_size)) << "run " << run << " step " << i;
      moving_contact_steps += felt.contact ? 1 : 0;
    }
  }
  EXPECT_GT(contact_steps, 20000);
  EXPECT_GT(moving_contact_steps, 10000);
}

// A hand that wanders over a ball of 30 mm at the origin, in steps of the given deviation. Frame S, m. tests/support/wandering_hand.h has
// one with a velocity.
struct WanderingHand {
  WanderingHand(std::uint64_t seed, double step_m) : random(seed), normal(0.0, step_m) {}
  const Vec3& next() {
    p += Vec3(normal(random), normal(random), normal(random));
    p *= 0.029 / p.norm() * 0.05 + 0.95;  // each step ends 5 % nearer to a radius of 29 mm, so 1 mm below the surface on average
    return p;
  }

  std::mt19937_64 random;
  std::normal_distribution<double> normal;
  Vec3 p = Vec3(0, 0, 0.035);
};

// MovingMethod has a method for each motion, here one for the ball and one for a far plate that hardly moves. The ball is felt as in a
// scene with a single method.
TEST(MovingMethod, IsTheSameAsOneMethodAsLongAsOneObjectIsTouched) {
  TouchScene still;
  still.objects.push_back({made::shared(made::sphere(0.03, 24, 0.05)), {.friction_static = 0.4, .friction_dynamic = 0.3}});
  still.objects.push_back(plate_object({0.2, -0.05, -0.01}, {0.25, 0.05, 0.0}));
  TouchScene with_motion = still;
  with_motion.objects[1].motion = shift_motion(Vec3::Zero(), Vec3(0.001, 0, 0), 100.0);
  const auto one = make_method_for(still);
  const auto several = make_method_for(with_motion);
  ASSERT_TRUE(one && several);
  const std::uint64_t seed = 17;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  WanderingHand hand(seed, 0.0008);
  one->reset(hand.p);
  several->reset(hand.p);
  int contact_steps = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3& p_SD = hand.next();
    const MethodOutput a = one->step({.p_SD = p_SD, .time_s = 1e-3 * i});
    const MethodOutput b = several->step({.p_SD = p_SD, .time_s = 1e-3 * i});
    // The contact offsets of the two differ: they scale with the scene, and the scene of MovingMethod's ball has one object less.
    ASSERT_LT((a.force_n - b.force_n).norm(), 2e-3 + 2e-3 * a.force_n.norm()) << i;
    contact_steps += a.contact ? 1 : 0;
  }
  EXPECT_GT(contact_steps, 1000);
}

// A moving object is felt like one that stands still under a hand that moves the other way.
TEST(MovingMethod, FeelsAMovingObjectAsAHandThatMovesTheOtherWay) {
  TouchScene moving;
  const auto motion = turn_motion({0.01, 0, 0}, Vec3(1, 2, 3).normalized(), 1.5, 10.0);
  moving.objects.push_back({.mesh = made::shared(made::sphere(0.03, 24, 0.05)), .material = {}, .motion = motion});
  TouchScene still = moving;
  still.objects[0].motion = nullptr;
  const auto on_moving = make_method_for(moving);
  const auto on_still = make_method_for(still);
  ASSERT_TRUE(on_moving && on_still);
  const std::uint64_t seed = 5;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  WanderingHand hand(seed, 0.0006);
  on_moving->reset(hand.p);
  on_still->reset(hand.p);
  for (int i = 0; i < 10000; ++i) {
    const Vec3& p_SD = hand.next();
    const Pose X_SO = motion->pose_at(1e-3 * i);
    const MethodOutput in_scene = on_moving->step({.p_SD = p_SD, .time_s = 1e-3 * i});
    const Pose X_OS = X_SO.inverse(Eigen::Isometry);
    const MethodOutput in_object = on_still->step({.p_SD = X_OS * p_SD});
    ASSERT_LT((in_scene.force_n - X_SO.linear() * in_object.force_n).norm(), 1e-6 * (1.0 + in_object.force_n.norm())) << i;
    ASSERT_EQ(in_scene.contact, in_object.contact) << i;
  }
}

TEST(MovingMethod, StartsWhereItIsReset) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.02}, 1.0)));
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  // At 0.5 s the top is at 10 mm. From above it, the first step comes into contact.
  method->reset({0, 0, 0.012});
  EXPECT_NEAR(method->step({.p_SD = {0, 0, 0.008}, .time_s = 0.5}).force_n.z(), 2.0, 1e-3);
  method->reset({0, 0, 0.03});
  EXPECT_FALSE(method->step({.p_SD = {0, 0, 0.03}, .time_s = 0.5}).contact);
}

TEST(MovingMethod, ASampleThatIsNotFiniteGivesNoForceAndChangesNothing) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.02}, 1.0)));
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  method->reset({0, 0, 0.002});
  const MethodInput pressed{.p_SD = {0, 0, -0.001}, .time_s = 0.0};
  const double before = method->step(pressed).force_n.z();
  EXPECT_GT(before, 0.9);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(method->step({.p_SD = Vec3::Constant(nan)}).force_n.isZero(0.0));
  EXPECT_TRUE(method->step({.p_SD = pressed.p_SD, .time_s = nan}).force_n.isZero(0.0));
  EXPECT_EQ(method->step(pressed).force_n.z(), before);
}

TEST(MovingMethod, TakesOtherMaterialsByObject) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.0, 0.05, 0.0}));
  scene.objects.push_back(plate_object({0.001, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.001}, 1.0)));
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  method->set_materials(std::vector<Material>{{.stiffness_n_per_m = 400.0}, {.stiffness_n_per_m = 700.0}});
  method->reset({-0.02, 0, 0.001});
  const MethodOutput left = method->step({.p_SD = {-0.02, 0, -0.001}});
  EXPECT_NEAR(left.force_n.z(), 0.4, 1e-4);
  EXPECT_EQ(left.object, 0);
  method->reset({0.02, 0, 0.001});
  const MethodOutput right = method->step({.p_SD = {0.02, 0, -0.001}});
  EXPECT_NEAR(right.force_n.z(), 0.7, 1e-4);
  EXPECT_EQ(right.object, 1);
}

TEST(MovingMethod, ListsTheObjectsThatProgramsDeformWhereverTheyStand) {
  TouchScene scene;
  for (int n = 0; n < 5; ++n) scene.objects.push_back(plate_object({0.1 * n, 0, 0}, {0.1 * n + 0.05, 0.05, 0.01}));
  scene.objects[4].stream_reach_m = 0.01;
  scene.objects[1].stream_reach_m = 0.01;
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  EXPECT_EQ(method->list_streamed(), (std::vector<int>{1, 4}));
  for (int n = 0; n < 5; ++n) EXPECT_EQ(method->find_streamed(n) != nullptr, n == 1 || n == 4) << n;
  scene.objects.resize(1);
  const auto rigid = make_method_for(scene);
  ASSERT_TRUE(rigid);
  EXPECT_TRUE(rigid->list_streamed().empty());
}

TEST(MovingMethod, OtherMethodsSayWhatFeelsMotion) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.02}, 1.0)));
  for (const char* name : {"smooth", "sweep"}) {
    const auto made = make_method({.name = name}, scene);
    ASSERT_FALSE(made) << name;
    EXPECT_EQ(made.error().what,
              std::string("method ") + name + ": objects of the scene move, which it does not support; choose proxy or reference");
  }
}

TEST(MovingMethod, BuildsOnApproachInEveryGroup) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.0, 0.05, 0.0}));
  scene.objects.push_back(plate_object({0.001, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.001}, 1.0)));
  MethodSettings settings;
  settings.build_on_approach = true;
  const auto method = make_method_for(scene, settings);
  ASSERT_TRUE(method);
  for (const double x : {-0.02, 0.02}) {
    method->reset({x, 0, 0.003});
    (void)method->step({.p_SD = {x, 0, 0.002}});
    while (method->prepare()) {
    }
    EXPECT_NEAR(method->step({.p_SD = {x, 0, -0.001}}).force_n.z(), 1.0, 1e-3) << x;
  }
}

TEST(MovingMethod, StepsWithoutHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.02}, 0.1)));
  scene.objects.push_back(plate_object({-0.05, -0.05, 0.03}, {0.05, 0.05, 0.04}));
  const auto method = make_method_for(scene);
  ASSERT_TRUE(method);
  const AllocationGuard guard;
  method->reset({0, 0, 0.005});
  double most_n = 0.0;
  for (int i = 0; i < 400; ++i)
    most_n = std::max(most_n, method->step({.p_SD = {0, 0, 0.005 + 1e-4 * i}, .time_s = 1e-3 * i}).force_n.norm());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(most_n, 1.0);
}

TEST(MovingMethod, SaysWhatMovesAndWhatStands) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.0, 0.05, 0.0}));
  for (int i = 0; i < 2; ++i) {
    // Equal motions are one group.
    scene.objects.push_back(plate_object({0.001, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.001}, 1.0)));
  }
  const std::string text = make_method_for(scene)->describe();
  EXPECT_EQ(text.find("objects that stand still: 1\n"), 0U) << text;
  EXPECT_NE(text.find("objects that move by themselves for 1 s: 2\n"), std::string::npos) << text;
}

// TouchStep passes the scene time on to the method, also while the dials have turned the scene.
TEST(MovingMethod, IsFeltInATurnedScene) {
  TouchScene scene;
  scene.objects.push_back(plate_object({-0.05, -0.05, -0.01}, {0.05, 0.05, 0.0}, shift_motion(Vec3::Zero(), {0, 0, 0.02}, 0.1)));
  auto made = make_method({}, scene);
  ASSERT_TRUE(made);
  TouchStep touch(std::move(*made), scene);
  EXPECT_TRUE(touch.has_motion());
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitX()).toRotationMatrix();
  TouchInput input{.p_WD = X_WS * Vec3(0, 0, 0.005), .X_WS = X_WS};
  touch.reset(input);
  TouchOutput felt;
  for (int i = 0; i <= 50; ++i) {
    input.time_s = 1e-3 * i;
    felt = touch.step(input);
  }
  EXPECT_LT((felt.force_n - X_WS.linear() * Vec3(0, 0, 5.0)).norm(), 1e-3);
  scene.objects[0].motion = nullptr;
  EXPECT_FALSE(TouchStep(touch.share_method(), scene).has_motion());
}

}  // namespace
}  // namespace hapton
