#include "core/tool/prepared_objects.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <tuple>

#include "core/geometry/mesh_shapes.h"
#include "core/tool/penetration_check.h"

namespace hapton {
namespace {

using Meshes = std::vector<std::shared_ptr<const TriangleMesh>>;

// A cube over a plate, beside a bumpy ball.
Meshes make_objects() {
  return {std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.2, 0.2, 0.01}, 3), 1.0, {0.0, 0.0, -0.005})),
          std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.02, 0.02, 0.02}, 2), 1.0, {0.0, 0.0, 0.011})),
          std::make_shared<TriangleMesh>(scaled_and_moved(make_bumpy_sphere(0.02, 0.05, 300, 4), 1.0, {0.05, 0.0, 0.02}))};
}

constexpr std::size_t kHeldCube = 1;
const std::vector<CoulombFriction> kRoughObjects = {{0.3, 0.2}, {0.1, 0.1}};

std::shared_ptr<const TriangleMesh> moved_copy(const TriangleMesh& mesh, const Vec3& shift) {
  return std::make_shared<TriangleMesh>(scaled_and_moved(mesh, 1.0, shift));
}

Pose grip_pose() {
  Pose X_SD = Pose::Identity();
  X_SD.translation() = Vec3(0.002, 0.001, 0.0205);
  X_SD.linear() = turn_by({0.3, -0.5, 0.9}).toRotationMatrix();
  return X_SD;
}

// The cube is lifted, pressed against the ball while it turns, and moved down onto the plate.
Pose pose_on_path(int n) {
  Pose X_WD = grip_pose();
  const double share = n / 400.0;
  X_WD.translation() += Vec3(0.04 * std::min(1.0, 2.0 * share), 0.004 * std::sin(9.0 * share), 0.02 * std::sin(3.14159 * share));
  if (share > 0.7) X_WD.translation().z() -= 0.02 * (share - 0.7);
  X_WD.linear() = turn_by({0.0, 0.4 * share, 0.6 * share}).toRotationMatrix() * X_WD.linear();
  return X_WD;
}

std::vector<ToolOutput> follow_path(ToolStep& step) {
  std::vector<ToolOutput> outputs;
  step.reset({.X_WD = grip_pose()});
  for (int n = 0; n <= 400; ++n) outputs.push_back(step.step({.X_WD = pose_on_path(n)}));
  return outputs;
}

void expect_same_bits(const std::vector<ToolOutput>& a, const std::vector<ToolOutput>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t n = 0; n < a.size(); ++n) {
    ASSERT_EQ(a[n].force_n, b[n].force_n) << n;
    ASSERT_EQ(a[n].torque_nm, b[n].torque_nm) << n;
    ASSERT_EQ(a[n].X_WP.matrix(), b[n].X_WP.matrix()) << n;
  }
}

std::unique_ptr<ToolStep> hold_cube(PreparedObjects& objects, const std::vector<CoulombFriction>& friction = {}) {
  auto step = objects.hold(kHeldCube, grip_pose(), {.stiffness_n_per_m = 800.0}, friction);
  EXPECT_TRUE(step) << step.error().what;
  return std::move(*step);
}

// A tool that is made from the cube's mesh, converted to the frame of the stylus at grip_pose().
std::unique_ptr<ToolStep> make_twin(const Meshes& meshes, const std::vector<CoulombFriction>& friction, const std::vector<int>& parts) {
  TriangleMesh mesh = *meshes[kHeldCube];
  const Pose X_DS = grip_pose().inverse(Eigen::Isometry);
  for (Vec3& v : mesh.vertices) v = X_DS * v;
  auto twin = ToolStep::make(mesh, {meshes[0], meshes[2]}, {.stiffness_n_per_m = 800.0}, friction, nullptr, parts);
  EXPECT_TRUE(twin);
  return std::move(*twin);
}

TEST(PreparedObjects, AHeldObjectIsFeltAsAToolOfItsMeshIs) {
  for (const std::vector<CoulombFriction>& friction : {std::vector<CoulombFriction>(), kRoughObjects}) {
    const Meshes meshes = make_objects();
    PreparedObjects objects(meshes);
    const auto held = hold_cube(objects, friction);
    const auto twin = make_twin(meshes, friction, {});
    EXPECT_NEAR(held->coupling().rotational_stiffness_nm_per_rad, twin->coupling().rotational_stiffness_nm_per_rad, 1e-12);
    const std::vector<ToolOutput> felt = follow_path(*held);
    const std::vector<ToolOutput> expected = follow_path(*twin);
    int in_contact = 0;
    for (std::size_t n = 0; n < felt.size(); ++n) {
      in_contact += expected[n].contact ? 1 : 0;
      ASSERT_LT((felt[n].force_n - expected[n].force_n).norm(), 1e-6 * (1.0 + expected[n].force_n.norm())) << n;
      ASSERT_LT((felt[n].torque_nm - expected[n].torque_nm).norm(), 1e-7) << n;
      ASSERT_TRUE(felt[n].X_WP.isApprox(expected[n].X_WP, 1e-7)) << n;
    }
    EXPECT_GT(in_contact, 100);
  }
}

TEST(PreparedObjects, AHeldObjectPenetratesNothing) {
  PreparedObjects objects(make_objects());
  const auto step = hold_cube(objects, kRoughObjects);
  PenetrationCheck check(step->tool(), step->scene());
  step->reset({.X_WD = grip_pose()});
  for (int n = 0; n <= 400; ++n) {
    step->step({.X_WD = pose_on_path(n)});
    ASSERT_FALSE(check.penetrates(step->proxy().placement())) << n;
  }
}

// The hand holds the cube still. The ball moves against it and turns past it; the plate stands still, moves, or moves with the ball.
// If it moves with the ball and there is friction, held object and twin may begin to slip in different steps: hence the larger bound.
TEST(PreparedObjects, AHeldObjectFeelsWhatMovesAsAToolOfItsMeshDoes) {
  for (const auto& [friction, parts, bound_n] :
       {std::tuple(std::vector<CoulombFriction>(), std::vector{0, 1}, 1e-9), std::tuple(kRoughObjects, std::vector{0, 1}, 1e-9),
        std::tuple(kRoughObjects, std::vector{2, 1}, 1e-9), std::tuple(std::vector<CoulombFriction>(), std::vector{1, 1}, 1e-9),
        std::tuple(kRoughObjects, std::vector{1, 1}, 3e-3)}) {
    const Meshes meshes = make_objects();
    PreparedObjects objects(meshes);
    const auto held = objects.hold(kHeldCube, grip_pose(), {.stiffness_n_per_m = 800.0}, friction, nullptr, parts);
    ASSERT_TRUE(held) << held.error().what;
    const auto twin = make_twin(meshes, friction, parts);
    std::vector<Pose> X_SO((*held)->moving_count(), Pose::Identity());
    ASSERT_EQ(X_SO.size(), twin->moving_count());
    for (ToolStep* step : {held->get(), twin.get()}) {
      ASSERT_TRUE(step->damp({{2.0, 0.0}, {0.0, 3.0}}));
      step->reset({.X_WD = grip_pose(), .X_SO = X_SO});
    }
    PenetrationCheck check((*held)->tool(), (*held)->moving(0));
    int in_contact = 0;
    for (int n = 0; n <= 400; ++n) {
      const double share = n / 400.0;
      X_SO[0].translation() = Vec3(-0.03 * share, 0.0, 0.002 * std::sin(6.0 * share));
      X_SO[0].linear() = turn_by({0.0, 0.0, 0.3 * share}).toRotationMatrix();
      if (X_SO.size() > 1) X_SO[1].translation() = Vec3(0.01 * share, 0.0, 0.0);
      const ToolInput input{.X_WD = grip_pose(), .X_SO = X_SO, .dt_s = 0.001};
      const ToolOutput felt = (*held)->step(input);
      const ToolOutput expected = twin->step(input);
      in_contact += expected.contact ? 1 : 0;
      ASSERT_LT((felt.force_n - expected.force_n).norm(), bound_n) << n;
      ASSERT_LT((felt.torque_nm - expected.torque_nm).norm(), 0.01 * bound_n) << n;
      ToolProxy& proxy = (*held)->proxy();
      ASSERT_FALSE(check.penetrates(proxy.part_placement(0).inverse() * proxy.placement())) << n;
    }
    EXPECT_GT(in_contact, 100);
  }
}

TEST(PreparedObjects, TooManyPartsThatMoveAreRejected) {
  Meshes meshes = make_objects();
  std::vector<int> parts = {0, 0};
  for (int n = 1; n <= ToolStep::kMaxParts + 1; ++n) {
    meshes.push_back(moved_copy(*meshes[2], {0.001 * n, 0.1, 0.0}));
    parts.push_back(n);
  }
  PreparedObjects objects(meshes);
  const auto step = objects.hold(kHeldCube, grip_pose(), {}, {}, nullptr, parts);
  ASSERT_FALSE(step);
  EXPECT_EQ(step.error().what,
            "33 parts of the scene move by themselves; a rigid tool touches 32 at most: let some stand still, or move together");
}

TEST(PreparedObjects, ItIsTheSameToTheBitWhetherItWasPreparedBeforeOrNot) {
  PreparedObjects prepared_before(make_objects());
  int prepared_count = 0;
  while (prepared_before.prepare_next()) ++prepared_count;
  EXPECT_EQ(prepared_count, 3);
  PreparedObjects not_yet(make_objects());
  EXPECT_EQ(not_yet.bytes(), 0U);
  const auto first = hold_cube(prepared_before, kRoughObjects);
  const auto second = hold_cube(not_yet, kRoughObjects);
  expect_same_bits(follow_path(*first), follow_path(*second));
  EXPECT_EQ(not_yet.bytes(), prepared_before.bytes());
  EXPECT_FALSE(not_yet.prepare_next());
}

TEST(PreparedObjects, WhatHasMovedIsPreparedAgainAndNothingElse) {
  Meshes meshes = make_objects();
  PreparedObjects objects(meshes);
  while (objects.prepare_next()) {
  }
  const auto ball = moved_copy(*meshes[2], {0.005, 0.003, 0.0});
  objects.replace(2, ball);
  EXPECT_TRUE(objects.prepare_next());
  EXPECT_FALSE(objects.prepare_next());
  meshes[2] = ball;
  PreparedObjects anew(meshes);
  ASSERT_EQ(anew.frame().origin, objects.frame().origin);
  const auto first = hold_cube(objects, kRoughObjects);
  const auto second = hold_cube(anew, kRoughObjects);
  expect_same_bits(follow_path(*first), follow_path(*second));
}

void expect_as_built_anew(const BuiltObjects& built, const Meshes& meshes) {
  ASSERT_EQ(built.meshes, meshes);
  Box box;
  for (const auto& mesh : make_objects()) {
    for (const Vec3& v : mesh->vertices) box.grow(v);
  }
  const TouchGeometry anew(meshes, BuildPolicy::at_once, built.shading_crease_rad, box);
  ASSERT_EQ(anew.origin(), built.frame.origin);
  ASSERT_EQ(anew.unit_m(), built.frame.unit_m);
  for (std::uint32_t o = 0; o < meshes.size(); ++o) {
    const ObjectGeometry& expected = anew.object_geometry(o);
    ASSERT_EQ(built.objects[o]->triangle_count(), expected.triangle_count());
    for (std::uint32_t t = 0; t < expected.triangle_count(); ++t) {
      for (int k = 0; k < 3; ++k) ASSERT_EQ(built.objects[o]->corner(t, k), expected.corner(t, k));
      ASSERT_EQ(built.objects[o]->adjacency().is_walkable(t), expected.adjacency().is_walkable(t)) << o << ", " << t;
      ASSERT_EQ(built.objects[o]->smooth_normal(t, expected.corner(t, 0)), expected.smooth_normal(t, expected.corner(t, 0)));
    }
  }
}

TEST(PreparedObjects, AProbeGetsThemMarkedWhereTheyTouchAndOnlyWhatHasMovedIsBuiltAgain) {
  for (const std::optional<double> crease_rad : {std::optional<double>(), std::optional(0.7)}) {
    Meshes meshes = make_objects();
    PreparedObjects objects(meshes, crease_rad);
    const auto first = objects.build();
    expect_as_built_anew(*first, meshes);
    EXPECT_EQ(objects.build()->objects, first->objects);
    EXPECT_EQ(objects.bytes(), 0U) << "for a probe alone, no features and trees are needed";
    while (objects.prepare_next()) {
    }
    EXPECT_EQ(objects.build()->objects, first->objects);
    // The cube is moved down onto the plate.
    meshes[kHeldCube] = moved_copy(*meshes[kHeldCube], {-0.03, 0.0, -0.001});
    objects.replace(kHeldCube, meshes[kHeldCube]);
    const auto second = objects.build();
    expect_as_built_anew(*second, meshes);
    EXPECT_NE(second->objects[0], first->objects[0]) << "other marks";
    EXPECT_EQ(second->objects[2], first->objects[2]) << "stays on the plate";
    EXPECT_LT(second->objects[0]->adjacency().walkable_count(), first->objects[0]->adjacency().walkable_count());
    EXPECT_TRUE(objects.prepare_next());
    EXPECT_FALSE(objects.prepare_next());
    // The cube is moved up again, into the air above another place.
    meshes[kHeldCube] = moved_copy(*make_objects()[kHeldCube], {-0.02, 0.05, 0.005});
    objects.replace(kHeldCube, meshes[kHeldCube]);
    const auto third = objects.build();
    expect_as_built_anew(*third, meshes);
    EXPECT_EQ(third->objects[0]->adjacency().walkable_count(), first->objects[0]->adjacency().walkable_count());
    EXPECT_EQ(third->objects[2], first->objects[2]);
  }
}

TEST(PreparedObjects, AToolIsTheSameToTheBitAfterAProbeHasItsObjects) {
  PreparedObjects objects(make_objects());
  objects.replace(kHeldCube, moved_copy(*make_objects()[kHeldCube], {0.0, 0.0, -0.001}));
  (void)objects.build();
  objects.replace(kHeldCube, make_objects()[kHeldCube]);
  (void)objects.build();
  const auto first = hold_cube(objects, kRoughObjects);
  PreparedObjects anew(make_objects());
  const auto second = hold_cube(anew, kRoughObjects);
  expect_same_bits(follow_path(*first), follow_path(*second));
}

TEST(PreparedObjects, AToolOutlivesWhatItWasPreparedFrom) {
  auto objects = std::make_unique<PreparedObjects>(make_objects());
  const auto kept = hold_cube(*objects);
  const auto other = hold_cube(*objects);
  const std::vector<ToolOutput> expected = follow_path(*other);
  objects->replace(0, moved_copy(*make_objects()[0], {0.0, 0.0, -0.01}));
  objects.reset();
  expect_same_bits(follow_path(*kept), expected);
}

// All objects have the same limit on their number of triangles after cracks are sealed. If it changes, all are prepared again.
TEST(PreparedObjects, AreAllPreparedAgainWhereOneHasManyMoreTriangles) {
  PreparedObjects objects(make_objects());
  const auto prepare_all = [&] {
    int prepared_count = 0;
    while (objects.prepare_next()) ++prepared_count;
    return prepared_count;
  };
  EXPECT_EQ(prepare_all(), 3);
  for (const int cells : {40, 2}) {
    objects.replace(kHeldCube,
                    std::make_shared<TriangleMesh>(scaled_and_moved(make_box({0.02, 0.02, 0.02}, cells), 1.0, {0.0, 0.0, 0.011})));
    EXPECT_EQ(prepare_all(), 3) << cells;
  }
}

TEST(PreparedObjects, TheFrameStaysWhereTheSceneSuitsItAndElseAllIsPreparedAgain) {
  const Meshes meshes = make_objects();
  PreparedObjects objects(meshes);
  const LocalFrame before = objects.frame();
  while (objects.prepare_next()) {
  }
  // The box of the scene is larger now, but within the frame.
  objects.replace(kHeldCube, moved_copy(*meshes[kHeldCube], {0.0, 0.0, 0.03}));
  EXPECT_EQ(objects.frame().origin, before.origin);
  EXPECT_TRUE(objects.prepare_next());
  EXPECT_FALSE(objects.prepare_next());
  // The cube is far outside the frame.
  Meshes far = meshes;
  far[kHeldCube] = moved_copy(*meshes[kHeldCube], {0.0, 0.0, 1.0});
  objects.replace(kHeldCube, far[kHeldCube]);
  EXPECT_EQ(objects.frame().origin, TouchGeometry(far).origin());
  EXPECT_EQ(objects.frame().unit_m, TouchGeometry(far).unit_m());
  int prepared_count = 0;
  while (objects.prepare_next()) ++prepared_count;
  EXPECT_EQ(prepared_count, 3);
  // The cube is back at its place: the scene is too small for the larger frame.
  objects.replace(kHeldCube, meshes[kHeldCube]);
  EXPECT_EQ(objects.frame().origin, before.origin);
  EXPECT_EQ(objects.frame().unit_m, before.unit_m);
  PreparedObjects anew(meshes);
  const auto first = hold_cube(objects);
  const auto second = hold_cube(anew);
  expect_same_bits(follow_path(*first), follow_path(*second));
}

TEST(PreparedObjects, AnObjectWithNothingToTouchIsNoTool) {
  PreparedObjects alone({make_objects()[1]});
  const auto only = alone.hold(0, Pose::Identity(), {});
  ASSERT_FALSE(only);
  EXPECT_EQ(only.error().what, "the scene has no triangles");
  PreparedObjects empty({std::make_shared<TriangleMesh>(), make_objects()[1]});
  const auto nothing = empty.hold(0, Pose::Identity(), {});
  ASSERT_FALSE(nothing);
  EXPECT_EQ(nothing.error().what, "the tool has no triangles");
  PreparedObjects two(make_objects());
  EXPECT_FALSE(two.hold(kHeldCube, Pose::Identity(), {.stiffness_n_per_m = -1.0}));
  EXPECT_FALSE(two.hold(kHeldCube, Pose::Identity(), {}, {{0.1, 0.2}}));
}

}  // namespace
}  // namespace hapton
