#include "core/force/touch_step.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "tests/support/allocation_guard.h"
#include "tests/support/made_meshes.h"

namespace hapton {
namespace {

TouchStep make_step_over_sheet() {
  return TouchStep(*make_method({.name = "sweep"}, {.objects = {{made::shared(made::sheet(0.1, 0.0, 4)), {}}}}));
}

TEST(TouchStep, ForceAndOffsetComeBackInTheWorldFrame) {
  // The sheet's normal +z turned to +x and moved to x = 0.5.
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix();
  X_WS.translation() = Vec3(0.5, 0.01, -0.02);
  TouchStep touch = make_step_over_sheet();
  touch.reset({.p_WD = {0.51, 0.03, 0.01}, .X_WS = X_WS});
  const TouchOutput felt = touch.step({.p_WD = {0.498, 0.03, 0.01}, .X_WS = X_WS});
  ASSERT_TRUE(felt.contact);
  EXPECT_NEAR((felt.force_n - Vec3(2.0, 0, 0)).norm(), 0.0, 1e-9);
  EXPECT_NEAR((felt.visual_offset_m - Vec3(0.002, 0, 0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(felt.object, 0);
}

TEST(TouchStep, FreeSpaceHasNoForceAndNoOffset) {
  TouchStep touch = make_step_over_sheet();
  touch.reset({.p_WD = {0, 0, 0.02}});
  const TouchOutput felt = touch.step({.p_WD = {0, 0, 0.01}});
  EXPECT_FALSE(felt.contact);
  EXPECT_EQ(felt.force_n, Vec3::Zero());
  EXPECT_EQ(felt.visual_offset_m, Vec3::Zero());
  EXPECT_EQ(felt.object, -1);
}

TEST(TouchStep, TurningTheSceneIntoAStationaryProbeExertsAForce) {
  TouchStep touch = make_step_over_sheet();
  const Vec3 p_WD(0.05, 0.001, 0.002);
  touch.reset({.p_WD = p_WD});
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(-0.1, Vec3::UnitY()).toRotationMatrix();  // raises the sheet at +x by 5 mm
  const TouchOutput felt = touch.step({.p_WD = p_WD, .X_WS = X_WS});
  ASSERT_TRUE(felt.contact);
  EXPECT_GT(felt.force_n[2], 2.5);
}

TouchScene sheet_with(const SurfaceEffects& effects, std::vector<SwitchedEffect> space = {}) {
  return {.objects = {{made::shared(made::sheet(0.1, 0.0, 4)), {}, effects}}, .effects = std::move(space)};
}

TouchStep make_step_over(const char* method, const TouchScene& scene) { return {*make_method({.name = method}, scene), scene}; }

// Effects are given in the frame of the scene, so they turn with the scene.
TEST(TouchStep, EffectsTurnWithTheScene) {
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(std::numbers::pi / 2, Vec3::UnitY()).toRotationMatrix();  // +z to +x
  X_WS.translation() = Vec3(0.5, 0.01, -0.02);
  const TouchScene scene = sheet_with({.progressive = {.n_per_m2 = 2e5}}, {ConstantEffect{.force_n = {0, 0, 0.25}}});
  for (const char* method : {"proxy", "smooth", "sweep", "reference"}) {
    TouchStep touch = make_step_over(method, scene);
    EXPECT_TRUE(touch.has_effects());
    touch.reset({.p_WD = {0.51, 0.03, 0.01}, .X_WS = X_WS});
    const TouchOutput free = touch.step({.p_WD = {0.505, 0.03, 0.01}, .X_WS = X_WS});
    EXPECT_TRUE(free.contact) << "an effect acts";
    EXPECT_LT((free.force_n - Vec3(0.25, 0, 0)).norm(), 1e-12);
    EXPECT_EQ(free.visual_offset_m, Vec3::Zero());
    EXPECT_EQ(free.object, -1) << "only effects in free space act";
    const TouchOutput pressed = touch.step({.p_WD = {0.498, 0.03, 0.01}, .X_WS = X_WS});
    // At a depth of 2 mm: 2 N of the spring, 0.8 N of the progressive part, and the constant force.
    EXPECT_LT((pressed.force_n - Vec3(3.05, 0, 0)).norm(), 1e-5) << method;
    EXPECT_LT((pressed.visual_offset_m - Vec3(0.002, 0, 0)).norm(), 1e-8) << method;
  }
}

// "Reset view" jumps; the knob box turns in small steps. Neither is a motion of the hand.
TEST(TouchStep, MovingTheSceneUnderAStillHandGivesNoVelocity) {
  TouchStep touch = make_step_over("proxy", sheet_with({}, {ViscousEffect{.damping_ns_per_m = 5.0}}));
  const Vec3 p_WD(0.05, 0.001, 0.02);
  touch.reset({.p_WD = p_WD});
  for (int i = 0; i < 20; ++i) (void)touch.step({.p_WD = p_WD});
  Pose X_WS = Pose::Identity();
  X_WS.translation() = Vec3(0.1, 0.0, -0.05);
  X_WS.linear() = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
  for (int i = 0; i < 20; ++i) EXPECT_LT(touch.step({.p_WD = p_WD, .X_WS = X_WS}).force_n.norm(), 1e-9) << i;
  const double moved_n = touch.step({.p_WD = p_WD + Vec3(1e-4, 0, 0), .X_WS = X_WS}).force_n.norm();
  EXPECT_GT(moved_n, 0.05) << "the hand's own motion counts";
}

TEST(TouchStep, MovingTheSceneAfterASampleThatIsNotFiniteIsNoVelocity) {
  TouchStep touch = make_step_over("proxy", sheet_with({}, {ViscousEffect{.damping_ns_per_m = 5.0}}));
  const Vec3 p_WD(0.05, 0.001, 0.02);
  touch.reset({.p_WD = p_WD});
  for (int i = 0; i < 20; ++i) (void)touch.step({.p_WD = p_WD});
  (void)touch.step({.p_WD = Vec3::Constant(std::numeric_limits<double>::quiet_NaN())});
  Pose X_WS = Pose::Identity();
  X_WS.translation() = Vec3(0.1, 0.0, -0.05);
  for (int i = 0; i < 20; ++i) EXPECT_LT(touch.step({.p_WD = p_WD, .X_WS = X_WS}).force_n.norm(), 1e-9) << i;
}

// A layer that a needle has punctured holds the needle; while a tool is held, there is no needle to hold.
TEST(TouchStep, BesideAToolNoProbeIsHeld) {
  SurfaceEffects effects;
  effects.layers.add({.depth_m = 0.0, .stiffness_n_per_m = 400.0, .pop_force_n = 1.0});
  TouchStep touch = make_step_over("proxy", sheet_with(effects));
  touch.reset({.p_WD = {0.01, 0.02, 0.002}});
  (void)touch.step({.p_WD = {0.01, 0.02, -0.005}});
  ASSERT_TRUE(touch.held_offset()) << "the needle has punctured the layer";
  EXPECT_NEAR(touch.held_offset()->z(), 0.005, 1e-6);
  (void)touch.step_in_space({.p_WD = {0.01, 0.02, -0.005}});
  EXPECT_FALSE(touch.held_offset());
}

// A sheet of 200 mm with the image of a ramp along x: every method gives the force that the ramp's formula gives.
TEST(TouchStep, MapsAreFeltWithEveryMethodAndUseNoHeap) {
  TouchScene scene = sheet_with({});
  auto triangles = std::make_shared<std::vector<MappedTriangle>>();
  const TriangleMesh& mesh = *scene.objects[0].mesh;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    MappedTriangle made;
    for (std::size_t k = 0; k < 3; ++k) {
      made.corner[k] = mesh.corner(t, static_cast<int>(k));
      made.texcoord[k] = (made.corner[k].head<2>() + Eigen::Vector2d(0.1, 0.1)) / 0.2;
    }
    triangles->push_back(made);
  }
  std::vector<float> texels;
  for (int n = 0; n < 64; ++n) texels.push_back((static_cast<float>(n) + 0.5F) / 64.0F);
  const auto ramp = std::make_shared<const SurfaceImage>(64, 1, std::move(texels));
  scene.objects[0].effects.maps = {.triangles = triangles, .height = {.image = ramp, .at_black = -0.001, .at_white = 0.0}};
  for (const char* method : {"proxy", "smooth", "sweep", "reference"}) {
    TouchStep touch = make_step_over(method, scene);
    ASSERT_TRUE(touch.has_effects());
    touch.reset({.p_WD = {-0.05, 0.003, 0.002}});
    (void)touch.step({.p_WD = {-0.05, 0.003, -0.002}});
    double worst_n = 0.0;
    const AllocationGuard guard;
    for (int n = 0; n < 100; ++n) {
      const Vec3 p(-0.05 + 1e-3 * n, 0.003 + 1e-4 * n, -0.002);
      const double pressed_m = 0.002 - 0.001 * (1.0 - (p.x() + 0.1) / 0.2);
      const Vec3 expected = 1000.0 * pressed_m * (Vec3::UnitZ() - 0.001 / 0.2 * Vec3::UnitX());
      // Each point is pressed from above, because in a slide the proxy of sweep stays behind.
      touch.reset({.p_WD = p + Vec3(0, 0, 0.004)});
      (void)touch.step({.p_WD = p + Vec3(0, 0, 0.003)});
      worst_n = std::max(worst_n, (touch.step({.p_WD = p}).force_n - expected).norm());
    }
    EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == 0U) << method;
    EXPECT_LT(worst_n, 1e-4) << method;
  }
}

TEST(TouchStep, ASceneWithoutEffectsIsTheMethodAloneToTheBit) {
  const TouchScene scene = sheet_with({});
  TouchStep with_scene = make_step_over("proxy", scene);
  TouchStep method_alone(*make_method({.name = "proxy"}, scene));
  EXPECT_FALSE(with_scene.has_effects());
  with_scene.reset({.p_WD = {0, 0, 0.01}});
  method_alone.reset({.p_WD = {0, 0, 0.01}});
  for (int k = 0; k < 200; ++k) {
    const Vec3 p(1e-4 * k, 2e-5 * k, 0.003 * std::cos(0.1 * k));
    const TouchOutput a = with_scene.step({.p_WD = p});
    const TouchOutput b = method_alone.step({.p_WD = p});
    ASSERT_EQ(a.force_n, b.force_n);
    ASSERT_EQ(a.visual_offset_m, b.visual_offset_m);
    ASSERT_EQ(a.contact, b.contact);
  }
}

TEST(TouchStep, ResetForgetsTheEffectsToo) {
  const TouchScene scene =
      sheet_with({.snap = {.range_m = 0.003}, .tap = {.ns_per_m = 5}}, {ViscousEffect{}, WaveEffect{.frequency_hz = 37}});
  TouchStep touch = make_step_over("proxy", scene);
  std::vector<Vec3> first;
  for (int run = 0; run < 2; ++run) {
    touch.reset({.p_WD = {0, 0, 0.002}});
    for (int k = 0; k < 300; ++k) {
      const TouchOutput output = touch.step({.p_WD = Vec3(1e-4 * k, 0, 0.002 * std::cos(0.1 * k))});
      if (run == 0)
        first.push_back(output.force_n);
      else
        ASSERT_EQ(output.force_n, first[k]) << k;
    }
  }
}

TEST(TouchStep, ASampleThatIsNotFiniteGivesNoForceWithEffects) {
  TouchStep touch = make_step_over("proxy", sheet_with({}, {ConstantEffect{.force_n = {0, 0, 1}}}));
  touch.reset({.p_WD = {0, 0, 0.002}});
  const TouchOutput output = touch.step({.p_WD = Vec3::Constant(std::numeric_limits<double>::quiet_NaN())});
  EXPECT_EQ(output.force_n, Vec3::Zero());
  EXPECT_FALSE(output.contact);
  EXPECT_EQ(touch.step({.p_WD = {0, 0, 0.002}}).force_n, Vec3(0, 0, 1));
}

TEST(TouchStep, EffectsUseNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  TouchStep touch =
      make_step_over("proxy", sheet_with({.progressive = {.n_per_m2 = 1e5},
                                          .layers = {},
                                          .bumps = {.height_m = 1e-3},
                                          .viscosity = {.damping_ns_per_m = 2},
                                          .snap = {.range_m = 0.002},
                                          .tap = {.ns_per_m = 5}},
                                         {SpringEffect{}, ViscousEffect{}, WaveEffect{}, BurstEffect{}, GravityWellEffect{}}));
  touch.reset({.p_WD = {0, 0, 0.002}});
  const AllocationGuard guard;
  for (int k = 0; k < 500; ++k) touch.step({.p_WD = Vec3(1e-5 * k, 0, 0.003 * std::cos(0.1 * k))});
  touch.reset({.p_WD = {0, 0, 0.002}});
  EXPECT_EQ(guard.count(), 0U);
}

// A press at 0.05 m/s into a surface of 1,000 N/m.
TEST(TouchStep, DampingOfMaterialsIsFeltWithEveryMethod) {
  TouchScene scene = sheet_with({});
  scene.objects[0].material = {.damping_ns_per_m = 4.0};
  for (const char* method : {"proxy", "reference", "smooth", "sweep"}) {
    TouchStep touch = make_step_over(method, scene);
    touch.reset({.p_WD = {0.003, 0.004, 0.0001}});
    Vec3 felt = Vec3::Zero();
    for (int n = 1; n <= 42; ++n) felt = touch.step({.p_WD = {0.003, 0.004, 0.0001 - 5e-5 * n}}).force_n;
    EXPECT_LT((felt - Vec3(0, 0, 2.0 + 4.0 * 0.05)).norm(), 1e-4) << method;
    for (int n = 0; n < 20; ++n) felt = touch.step({.p_WD = {0.003, 0.004, -0.002}}).force_n;
    EXPECT_LT((felt - Vec3(0, 0, 2.0)).norm(), 1e-4) << method;
    for (int n = 1; n <= 10; ++n) felt = touch.step({.p_WD = {0.003, 0.004, -0.002 + 5e-5 * n}}).force_n;
    EXPECT_LT((felt - Vec3(0, 0, 1.5 - 4.0 * 0.05)).norm(), 1e-4) << method;
  }
}

// A slide 2 mm deep on a surface of 1,000 N/m: after 1 mm the tangential force, 1 N, is still below static friction, 0.6 times 2 N.
TEST(TouchStep, FrictionOfMaterialsIsFeltWithEveryMethod) {
  TouchScene scene = sheet_with({});
  scene.objects[0].material = {.friction_static = 0.6, .friction_dynamic = 0.3};
  for (const char* method : {"proxy", "reference", "smooth", "sweep"}) {
    TouchStep touch = make_step_over(method, scene);
    touch.reset({.p_WD = {0.003, 0.004, 0.0001}});
    Vec3 felt = Vec3::Zero();
    std::uint64_t allocations = 0;
    {
      const AllocationGuard guard;
      for (int n = 1; n <= 42; ++n) felt = touch.step({.p_WD = {0.003, 0.004, 0.0001 - 5e-5 * n}}).force_n;
      for (int n = 1; n <= 10; ++n) felt = touch.step({.p_WD = {0.003 + 1e-4 * n, 0.004, -0.002}}).force_n;
      allocations = guard.count();
    }
    EXPECT_LT((felt - Vec3(-1.0, 0, 2.0)).norm(), 1e-4) << method;
    for (int n = 11; n <= 100; ++n) felt = touch.step({.p_WD = {0.003 + 1e-4 * n, 0.004, -0.002}}).force_n;
    EXPECT_LT((felt - Vec3(-0.6, 0, 2.0)).norm(), 1e-4) << method;
    EXPECT_TRUE(!AllocationGuard::is_available() || allocations == 0U) << method;
  }
}

// `hapton set` can give damping and friction to an object that had none, and take them away again.
TEST(TouchStep, DampingAndFrictionCanBeGivenWhileAMethodWithoutThemRuns) {
  for (const char* method : {"smooth", "sweep"}) {
    TouchScene scene = sheet_with({});
    TouchStep touch = make_step_over(method, scene);
    EXPECT_FALSE(touch.has_effects()) << method;
    Vec3 p(0.0, 0.004, 0.0001);
    touch.reset({.p_WD = p});
    const std::vector<Material> rough = {{.friction_static = 0.5, .friction_dynamic = 0.5}};
    const std::vector<Material> slippery = {{}};
    const AllocationGuard guard;
    const auto slide = [&](int steps) {
      Vec3 felt = Vec3::Zero();
      for (int n = 0; n < steps; ++n) felt = touch.step({.p_WD = p += Vec3(1e-4, 0, 0)}).force_n;
      return felt;
    };
    p.z() = -0.001;
    EXPECT_NEAR(slide(20).x(), 0.0, 1e-9) << method;
    const std::uint64_t before = guard.count();
    touch.set_materials(rough);
    EXPECT_TRUE(!AllocationGuard::is_available() || guard.count() == before) << method;
    EXPECT_TRUE(touch.has_effects()) << method;
    EXPECT_NEAR(slide(40).x(), -0.5, 1e-4) << method;
    touch.set_materials(slippery);
    EXPECT_FALSE(touch.has_effects()) << method;
    EXPECT_NEAR(slide(3).x(), 0.0, 1e-9) << method;
  }
}

// The coupling reduces the damping as it does in the materials of the method (couple_material).
TEST(TouchStep, DampingOfACoupledMethodIsCoupled) {
  TouchScene scene = sheet_with({});
  scene.objects[0].material = {.stiffness_n_per_m = 1000.0, .damping_ns_per_m = 8.0};
  TouchStep touch(*make_method({.name = "sweep", .coupling_n_per_m = 1000.0}, scene), scene);
  touch.reset({.p_WD = {0, 0.004, 0.0001}});
  Vec3 felt = Vec3::Zero();
  for (int n = 1; n <= 20; ++n) felt = touch.step({.p_WD = {0, 0.004, 0.0001 - 1e-4 * n}}).force_n;
  // Two springs of 1,000 N/m in series: half of the stiffness, a quarter of the damping.
  EXPECT_NEAR(felt.z(), 500.0 * 0.0019 + 0.25 * 8.0 * 0.1, 1e-6);
}

}  // namespace
}  // namespace hapton
