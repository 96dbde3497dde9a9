#include "core/force/sculpt/sculpt_method.h"

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "core/force/touch_step.h"
#include "core/geometry/mesh_shapes.h"
#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr SculptSettings kClayBall{.voxel_m = 0.002, .tool_radius_m = 0.006, .button = 2};

TouchObject clay_object(const Vec3& centre, double radius_m = 0.03) {
  return {.mesh = std::make_shared<const TriangleMesh>(scaled_and_moved(make_icosphere(radius_m, 4), 1.0, centre)),
          .material = {.stiffness_n_per_m = 500.0},
          .sculpt = kClayBall};
}

TouchObject table_object() {
  return {.mesh = std::make_shared<const TriangleMesh>(scaled_and_moved(make_box(Vec3(0.2, 0.2, 0.02)), 1.0, Vec3(0, 0, -0.06))),
          .material = {.stiffness_n_per_m = 1000.0}};
}

std::unique_ptr<TouchStep> step_of(const TouchScene& scene, const MethodSettings& settings = {}) {
  auto made = make_method(settings, scene);
  EXPECT_TRUE(made) << made.error().what;
  return std::make_unique<TouchStep>(std::shared_ptr<ForceMethod>(std::move(*made)), scene);
}

// A hand that wanders into the clay and out of it, and presses the button now and then.
std::vector<TouchInput> carving_hand(std::uint64_t seed, int count) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> push(0.0, 2e-4);
  std::vector<TouchInput> hand;
  Vec3 p(0.05, 0, 0), v = Vec3::Zero();
  for (int i = 0; i < count; ++i) {
    v = 0.97 * v + Vec3(push(random), push(random), push(random)) * 0.3 - 0.0008 * (p - 0.03 * p.normalized());
    p += v;
    hand.push_back({.p_WD = p, .dt_s = 1e-3, .buttons = (i / 300) % 2 == 0 ? 0U : 3U, .time_s = 1e-3 * i});
  }
  return hand;
}

TEST(SculptMethod, FeelsOtherObjectsAsTheirMethodDoes) {
  TouchScene with{.objects = {table_object(), clay_object(Vec3::Zero())}};
  TouchScene without{.objects = {table_object()}};
  for (TouchScene* scene : {&with, &without}) {
    Material& table = scene->objects[0].material;
    table.damping_ns_per_m = 2.0;
    table.friction_static = 0.4;
    table.friction_dynamic = 0.2;
  }
  for (const char* name : {"proxy", "reference", "smooth", "sweep"}) {
    const auto one = step_of(with, {.name = name}), other = step_of(without, {.name = name});
    int contacts = 0;
    for (int i = 0; i < 200; ++i) {
      const TouchInput input{.p_WD = {0.06, 0.0001 * i, -0.048 - 0.0002 * std::abs(i - 100)}};
      const TouchOutput a = one->step(input), b = other->step(input);
      ASSERT_EQ(a.force_n, b.force_n) << name;
      ASSERT_EQ(a.visual_offset_m, b.visual_offset_m);
      ASSERT_EQ(a.contact, b.contact);
      if (a.contact) {
        ASSERT_EQ(a.object, b.object);
      }
      contacts += a.contact;
    }
    EXPECT_GT(contacts, 15) << name;
  }
}

// Effects of the table change the force by the same amount whether or not a carved body is touched too: with proxy where the two meet at
// right angles; with smooth, where the two are in series, also where the body pushes up as the table does, or pushes the hand into the
// table. Sweep is left out: its collision point lags behind the hand and never reaches the body.
TEST(SculptMethod, EffectsOfAnotherObjectAreThoseOfItsOwnForce) {
  const auto with_drag = [](TouchObject& table) {
    table.material.damping_ns_per_m = 2.0;
    table.material.friction_static = 0.4;
    table.material.friction_dynamic = 0.2;
  };
  const auto with_effects = [](TouchObject& table) {
    table.effects.progressive.n_per_m2 = 2e5;
    table.effects.viscosity.damping_ns_per_m = 3.0;
  };
  TouchObject block = clay_object(Vec3::Zero());
  block.mesh = std::make_shared<const TriangleMesh>(scaled_and_moved(make_box(Vec3(0.06, 0.06, 0.1)), 1.0, Vec3(0, 0, -0.05)));
  struct Case {
    const char* method;
    std::function<void(TouchObject&)> change;
    TouchObject clay;
    double tolerance;  // relative; the field of the block holds floats
  };
  const TouchObject above = clay_object(Vec3(0, 0, -0.03)), below = clay_object(Vec3(0, 0, -0.016));
  const Case cases[] = {{"smooth", with_drag, above, 1e-12},
                        {"smooth", with_drag, below, 1e-12},
                        {"smooth", with_effects, above, 1e-12},
                        {"smooth", with_effects, below, 1e-12},
                        {"proxy", with_effects, block, 1e-6}};
  for (const Case& test_case : cases) {
    std::vector<std::unique_ptr<TouchStep>> steps;  // with the body, without it; first without effects, then with them
    for (const bool has_effects : {false, true}) {
      for (const bool has_body : {true, false}) {
        TouchScene scene{.objects = {table_object()}};
        if (has_body) scene.objects.push_back(test_case.clay);
        if (has_effects) test_case.change(scene.objects[0]);
        steps.push_back(step_of(scene, {.name = test_case.method}));
      }
    }
    int both_pushing_steps = 0;
    for (int i = 0; i < 500; ++i) {
      const double down = std::min(i, 100) * 4e-5, along = std::max(i - 100, 0) * 1.5e-4;
      std::vector<TouchOutput> felt;
      for (const auto& step : steps) felt.push_back(step->step({.p_WD = {0.06 - along, 0.0, -0.048 - down}, .dt_s = 1e-3}));
      if (felt[0].object != 0) continue;  // the body pushes most: its own drag counts, not that of the table
      both_pushing_steps += (felt[0].force_n - felt[1].force_n).norm() > 0.1;
      const Vec3 beside_body = felt[2].force_n - felt[0].force_n, alone = felt[3].force_n - felt[1].force_n;
      ASSERT_LT((beside_body - alone).norm(), test_case.tolerance * (1.0 + felt[0].force_n.norm())) << test_case.method << ", step " << i;
      ASSERT_LT((felt[2].visual_offset_m - felt[0].visual_offset_m).norm(), 1e-12);
    }
    EXPECT_GT(both_pushing_steps, 10) << test_case.method;
  }
}

// Damping resists the motion into the material, and never pulls the hand towards it.
TEST(SculptMethod, DampingActsAlongTheExtension) {
  TouchObject clay = clay_object(Vec3::Zero());
  clay.material.damping_ns_per_m = 2.0;
  const auto step = step_of({.objects = {clay}});
  const auto force_at = [&](double x, double dt_s = 1e-3) { return step->step({.p_WD = {x, 0, 0}, .dt_s = dt_s}).force_n.x(); };
  EXPECT_EQ(force_at(0.04), 0.0);
  const double pressed_n = force_at(0.033);
  for (int i = 0; i < 20; ++i) force_at(0.033);
  const double held_n = force_at(0.033);
  EXPECT_NEAR(held_n, 500.0 * 1.5e-3, 0.2) << "the spring alone";
  EXPECT_NEAR(pressed_n, held_n * (1.0 + 2.0 / (500.0 * 1e-3)), 0.08 * pressed_n) << "pressed in within 1 ms";
  const TouchOutput out = step->step({.p_WD = {0.0335, 0, 0}});
  EXPECT_EQ(out.force_n.x(), 0.0) << "not below zero";
  EXPECT_TRUE(out.contact) << "the clay holds it all the same";
  EXPECT_EQ(out.object, 0);
  EXPECT_GT(out.visual_offset_m.x(), 0.0);
  for (int i = 0; i < 20; ++i) force_at(0.0335);
  const double before_n = force_at(0.0335);
  EXPECT_NEAR(force_at(0.0336, 0.01), before_n - 500.0 * 1e-4 - 2.0 * 1e-4 / 0.01, 0.005) << "slowly out";
  EXPECT_NEAR(force_at(0.033, 0.0), held_n, 0.02) << "no time, no speed";
}

// Between clay and table, the object that pushes more is named; the force is the sum.
TEST(SculptMethod, NamesTheObjectThatPushesMost) {
  TouchScene scene{.objects = {table_object(), clay_object(Vec3(0, 0, -0.045))}};
  const auto step = step_of(scene);
  const auto felt_at = [&](const Vec3& p) {
    step->reset({.p_WD = {0.07, 0, -0.03}});
    step->step({.p_WD = {0.07, 0, -0.03}});
    TouchOutput felt;
    for (int i = 0; i < 10; ++i) felt = step->step({.p_WD = p});
    return felt;
  };
  const TouchOutput on_table = felt_at({0.034, 0, -0.0505});
  EXPECT_EQ(on_table.object, 0);
  EXPECT_GT(on_table.force_n.x(), 0.01) << "and of the clay";
  EXPECT_GT(on_table.force_n.z(), 0.4);
  const TouchOutput on_clay = felt_at({0.030, 0, -0.0501});
  EXPECT_EQ(on_clay.object, 1);
  EXPECT_GT(on_clay.force_n.x(), 1.0);
}

TEST(SculptMethod, IsHeldWhereItTouchesAndNowhereElse) {
  const auto step = step_of({.objects = {clay_object(Vec3::Zero()), table_object()}});
  const auto held_at = [&](const Vec3& p) {
    const TouchOutput felt = step->step({.p_WD = p});
    const auto held = step->method().held_at();
    EXPECT_EQ(held.has_value(), felt.contact);
    EXPECT_TRUE(!held || (*held - p - felt.visual_offset_m).norm() < 1e-12);
    return held;
  };
  EXPECT_FALSE(held_at({0.05, 0, 0}));
  ASSERT_TRUE(held_at({0.033, 0, 0})) << "clay";
  step->reset({.p_WD = {0.08, 0, -0.04}});
  EXPECT_FALSE(step->method().held_at());
  EXPECT_TRUE(held_at({0.08, 0, -0.051})) << "table";
  EXPECT_FALSE(held_at({0.08, 0, -0.03}));
  // The method resumes where another method held the probe: on the clay. Then the hand goes 3 mm deeper.
  step->resume({.p_WD = {0.035, 0, 0}});
  EXPECT_GT(step->step({.p_WD = {0.032, 0, 0}}).force_n.x(), 0.5);
}

TEST(SculptMethod, IsDescribed) {
  SCOPED_TRACE("seed 48");
  const auto step = step_of({.objects = {table_object(), clay_object(Vec3::Zero())}});
  const std::array<int, 3>& nodes = step->method().sculpture()->bodies()[0].field.nodes();
  const double mib = nodes[0] * nodes[1] * nodes[2] * 4.0 / 1048576.0;
  EXPECT_THAT(step->method().describe(),
              testing::EndsWith(fmt::format("object 1 can be carved: {} x {} x {} voxels of 2 mm ({:.1f} MiB), ball of 6 mm radius\n",
                                            nodes[0], nodes[1], nodes[2], mib)));
  for (const TouchInput& input : carving_hand(48, 1500)) step->step(input);
  EXPECT_THAT(step->method().describe(), testing::EndsWith(fmt::format("carves: {}\n", step->method().sculpture()->newest())));
}

TEST(SculptMethod, CarvesByItsButtonOnlyAndNamesTheObject) {
  SCOPED_TRACE("seed 41");
  const auto step = step_of({.objects = {table_object(), clay_object(Vec3::Zero())}});
  int carves = 0;
  std::uint32_t serial = 0;
  for (const TouchInput& input : carving_hand(41, 4000)) {
    const TouchOutput felt = step->step(input);
    const MadeCarve* made = step->made_carve();
    if (made == nullptr) continue;
    ++carves;
    EXPECT_EQ(made->serial, ++serial);
    EXPECT_EQ(made->object, 1);
    EXPECT_NE(input.buttons, 0U);
    EXPECT_EQ(made->carve.radius_m, static_cast<double>(static_cast<float>(kClayBall.tool_radius_m)));
    EXPECT_TRUE(felt.force_n.allFinite());
  }
  EXPECT_GT(carves, 50);
  const auto other = step_of({.objects = {clay_object(Vec3::Zero())}});
  for (TouchInput input : carving_hand(41, 4000)) {
    input.buttons &= 1U;  // without the button of the clay
    other->step(input);
    ASSERT_EQ(other->made_carve(), nullptr);
  }
}

// Another object beside the clay, out of reach, changes nothing, whatever the method: it does not divide the step of a ball that cuts into
// several steps.
TEST(SculptMethod, CutsTheSameBesideAnObjectThatIsFar) {
  SCOPED_TRACE("seed 7");
  TouchObject far = table_object();
  far.mesh = std::make_shared<const TriangleMesh>(scaled_and_moved(make_box(Vec3(0.02, 0.02, 0.02)), 1.0, Vec3(0, 0, -0.4)));
  for (const char* name : {"proxy", "reference", "smooth", "sweep"}) {
    const auto alone = step_of({.objects = {clay_object(Vec3::Zero())}}, {.name = name});
    const auto beside = step_of({.objects = {far, clay_object(Vec3::Zero())}}, {.name = name});
    int cutting_steps = 0;
    for (const TouchInput& input : carving_hand(7, 1500)) {
      const TouchOutput a = alone->step(input), b = beside->step(input);
      ASSERT_EQ(a.force_n, b.force_n) << name;
      ASSERT_LT((a.visual_offset_m - b.visual_offset_m).norm(), 1e-15);
      cutting_steps += a.contact && input.buttons != 0 ? 1 : 0;
    }
    EXPECT_GT(cutting_steps, 100) << name;
    EXPECT_EQ(alone->method().sculpture()->newest(), beside->method().sculpture()->newest()) << name;
  }
}

TEST(SculptMethod, RepeatsToTheLastBit) {
  SCOPED_TRACE("seed 42");
  const TouchScene scene{.objects = {clay_object(Vec3::Zero()), table_object(), clay_object(Vec3(0.05, 0.01, 0.0), 0.02)}};
  const auto one = step_of(scene), other = step_of(scene);
  auto replica = std::make_unique<Sculpture>();  // gets only the carves; its fields must become the same
  ASSERT_TRUE(replica->add(0, kClayBall, *scene.objects[0].mesh) && replica->add(2, kClayBall, *scene.objects[2].mesh));
  bool has_carved_second = false, has_carved_first = false;
  for (const TouchInput& input : carving_hand(42, 5000)) {
    const TouchOutput a = one->step(input), b = other->step(input);
    ASSERT_EQ(a.force_n, b.force_n);
    ASSERT_EQ(a.visual_offset_m, b.visual_offset_m);
    const MadeCarve* made = one->made_carve();
    ASSERT_EQ(made == nullptr, other->made_carve() == nullptr);
    if (made == nullptr) continue;
    EXPECT_EQ(made->carve, other->made_carve()->carve);
    replica->begin_step();
    replica->carve(made->object == 0 ? 0 : 1, made->carve);
    has_carved_first = has_carved_first || made->object == 0;
    has_carved_second = has_carved_second || made->object == 2;
  }
  EXPECT_TRUE(has_carved_first && has_carved_second);
  for (std::size_t body = 0; body < 2; ++body) {
    const auto values = one->method().sculpture()->bodies()[body].field.values();
    const auto replica_values = replica->bodies()[body].field.values();
    EXPECT_TRUE(std::equal(values.begin(), values.end(), replica_values.begin(), replica_values.end()));
  }
}

// A hand of up to 2 m/s, the button down now and then: the centre of the ball stays out of the material, and a device inside it is pushed.
TEST(SculptMethod, AFastHandNeverFallsThrough) {
  SCOPED_TRACE("seed 47");
  std::mt19937_64 random(47);
  std::uniform_real_distribution<double> place(-0.045, 0.045), speed(0.2, 2.0);
  const auto step = step_of({.objects = {clay_object(Vec3::Zero())}});
  const CarvedField& field = step->method().sculpture()->bodies()[0].field;
  Vec3 hand(0.06, 0, 0);
  step->reset({.p_WD = hand});
  int steps_inside = 0;
  for (int leg = 0; leg < 300; ++leg) {
    const Vec3 goal(place(random), place(random), place(random));
    const double step_m = 1e-3 * speed(random);
    while (hand != goal) {
      const double remaining_m = (goal - hand).norm();
      hand = remaining_m <= step_m ? goal : Vec3(hand + (goal - hand) * (step_m / remaining_m));
      const TouchOutput felt = step->step({.p_WD = hand, .dt_s = 1e-3, .buttons = leg % 4 == 3 ? 2U : 0U});
      ASSERT_GT(field.value(hand + felt.visual_offset_m), 0.0) << "leg " << leg;
      if (field.value(hand) > -0.00025) continue;
      ++steps_inside;
      ASSERT_GT(felt.force_n.norm(), 0.0) << "leg " << leg;
    }
  }
  EXPECT_GT(steps_inside, 1000);
}

TEST(SculptMethod, WhatWasCarvedStaysWhenTheMethodChanges) {
  SCOPED_TRACE("seed 43");
  const TouchScene scene{.objects = {clay_object(Vec3::Zero())}};
  auto before = step_of(scene);
  for (const TouchInput& input : carving_hand(43, 3000)) before->step(input);
  const std::uint32_t carves = before->method().sculpture()->newest();
  ASSERT_GT(carves, 20U);
  const Sculpture* shape = before->method().sculpture();
  const auto after = step_of(scene, {.name = "reference"});
  after->exchange_carves(*before);
  EXPECT_EQ(after->method().sculpture(), shape);
  EXPECT_EQ(before->method().sculpture()->newest(), 0U);
  // Carves are not exchanged between methods of different scenes.
  const auto other = step_of({.objects = {clay_object(Vec3(0, 0, 0.001))}});
  other->exchange_carves(*after);
  EXPECT_EQ(other->method().sculpture()->newest(), 0U);
  // An exchange with itself changes nothing.
  after->exchange_carves(*after);
  EXPECT_EQ(after->method().sculpture()->newest(), carves);
}

TEST(SculptMethod, InATurnedSceneTheForceTurnsAlong) {
  SCOPED_TRACE("seed 44");
  const TouchScene scene{.objects = {clay_object(Vec3::Zero())}};
  const auto straight = step_of(scene), turned = step_of(scene);
  Pose X_WS = Pose::Identity();
  X_WS.linear() = Eigen::AngleAxisd(0.5, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  X_WS.translation() = Vec3(0.01, -0.02, 0.03);
  for (TouchInput input : carving_hand(44, 600)) {
    input.buttons = 0;
    const TouchOutput a = straight->step(input);
    input.p_WD = X_WS * input.p_WD;
    input.X_WS = X_WS;
    const TouchOutput b = turned->step(input);
    ASSERT_LT((X_WS.linear() * a.force_n - b.force_n).norm(), 1e-3);
  }
}

TEST(SculptMethod, ASampleThatIsNotFiniteChangesNothing) {
  SCOPED_TRACE("seed 45");
  const TouchScene scene{.objects = {clay_object(Vec3::Zero())}};
  const auto one = step_of(scene), other = step_of(scene);
  int i = 0;
  for (const TouchInput& input : carving_hand(45, 2000)) {
    if (i++ % 50 == 0) {
      TouchInput bad = input;
      bad.p_WD.y() = std::numeric_limits<double>::quiet_NaN();
      EXPECT_TRUE(one->step(bad).force_n.isZero(0.0));
      EXPECT_EQ(one->made_carve(), nullptr);
    }
    ASSERT_EQ(one->step(input).force_n, other->step(input).force_n);
  }
}

TEST(SculptMethod, StepsUseNoHeap) {
  SCOPED_TRACE("seed 46");
  if (!AllocationGuard::is_available()) GTEST_SKIP();
  const TouchScene scene{.objects = {clay_object(Vec3::Zero()), table_object()}};
  const auto step = step_of(scene), next = step_of(scene);
  const std::vector<TouchInput> hand = carving_hand(46, 3000);
  const AllocationGuard guard;
  for (const TouchInput& input : hand) step->step(input);
  next->exchange_carves(*step);
  next->reset(hand.back());
  next->step(hand.back());
  EXPECT_EQ(guard.count(), 0U);
  EXPECT_GT(next->method().sculpture()->newest(), 20U);
}

TEST(SculptMethod, MaterialsOfBothKindsCanBeChanged) {
  const auto step = step_of({.objects = {clay_object(Vec3::Zero()), table_object()}});
  step->reset({.p_WD = {0.05, 0, 0}});
  const TouchInput pressed{.p_WD = {0.03, 0, 0}};
  for (int i = 0; i < 30; ++i) step->step(pressed);
  const double before = step->step(pressed).force_n.norm();
  step->set_materials(std::vector<Material>{{.stiffness_n_per_m = 1000.0}, {.stiffness_n_per_m = 200.0}});
  EXPECT_NEAR(step->step(pressed).force_n.norm(), 2.0 * before, 1e-9);
  step->reset({.p_WD = {0.08, 0, -0.04}});
  EXPECT_NEAR(step->step({.p_WD = {0.08, 0, -0.051}}).force_n.z(), 0.2, 1e-3);
}

TEST(SculptMethod, FindsTheObjectThatProgramsDeformBesideIt) {
  TouchObject deformable_table = table_object();
  deformable_table.stream_reach_m = 0.01;
  const auto step = step_of({.objects = {clay_object(Vec3::Zero()), deformable_table}});
  EXPECT_EQ(step->find_streamed(0), nullptr);
  EXPECT_NE(step->find_streamed(1), nullptr);
  EXPECT_EQ(step->method().list_streamed(), std::vector<int>{1});
}

TEST(SculptMethod, RejectsAnOpenMesh) {
  TouchObject sheet = clay_object(Vec3::Zero());
  sheet.mesh = std::make_shared<const TriangleMesh>(make_plane_grid(0.05, 3));
  const auto made = make_method({}, {.objects = {table_object(), sheet}});
  ASSERT_FALSE(made);
  EXPECT_THAT(made.error().what, testing::HasSubstr("object 1 cannot be carved: the mesh is not closed"));
  EXPECT_FALSE(make_method({.name = "none"}, {.objects = {clay_object(Vec3::Zero())}}));
}

}  // namespace
}  // namespace hapton
