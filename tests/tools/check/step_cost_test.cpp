#include "tools/check/step_cost.h"

#include <gtest/gtest.h>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

Scene scene_of(std::vector<TriangleMesh> meshes) {
  Scene scene;
  for (TriangleMesh& mesh : meshes) {
    scene.objects.push_back(
        {.name = std::to_string(scene.objects.size()), .mesh = std::make_shared<TriangleMesh>(std::move(mesh)), .material = {}});
  }
  return scene;
}

TEST(StepCost, SlidesOverEveryObject) {
  const auto cost = measure_step_cost(scene_of({make_icosphere(0.04, 3), scaled_and_moved(make_icosphere(0.02, 2), 1.0, Vec3(0.1, 0, 0))}),
                                      {.steps = 4000, .repeat = 2});
  ASSERT_TRUE(cost) << cost.error().what;
  EXPECT_EQ(cost->steps, 4000U);
  EXPECT_GT(cost->worst_ns, 0);
  EXPECT_LE(cost->p99_ns, cost->worst_ns);
  EXPECT_TRUE(cost->worst_object == "0" || cost->worst_object == "1");
  EXPECT_LT(cost->worst_at_m.norm(), 0.15);
}

TEST(StepCost, ASlideIsLongEnoughToTouch) {
  const auto cost = measure_step_cost(scene_of({make_icosphere(0.04, 2)}), {.rate_hz = 1e6, .steps = 100, .repeat = 1});
  ASSERT_TRUE(cost);
  EXPECT_EQ(cost->steps, 10'000U) << "one second at 10 kHz";
}

TEST(StepCost, WhatTheMethodRejectsIsAnError) {
  EXPECT_FALSE(measure_step_cost(scene_of({TriangleMesh{}}), {}));
  EXPECT_FALSE(measure_step_cost(Scene{}, {}));
}

// A cycle of 10 kHz lasts 100 us: half of it for the 99th percentile, all of it for the worst step.
TEST(StepCost, IsComparedWithTheCycle) {
  StepCost cost{.steps = 1000, .p99_ns = 49'000, .worst_ns = 99'000, .worst_object = "lamp", .worst_at_m = Vec3(1, 2, 3)};
  EXPECT_TRUE(check_cost(cost, 10'000.0).empty());
  cost.worst_ns = 101'000;
  const CheckFindings worst = check_cost(cost, 10'000.0);
  ASSERT_EQ(worst.size(), 1U);
  EXPECT_EQ(worst[0].fault, SceneFault::too_slow);
  EXPECT_EQ(worst[0].object, "lamp");
  EXPECT_EQ(worst[0].place_m, std::optional(Vec3(1, 2, 3)));
  cost.worst_ns = 99'000;
  cost.p99_ns = 51'000;
  EXPECT_EQ(check_cost(cost, 10'000.0).size(), 1U);
  EXPECT_TRUE(check_cost(cost, 9'000.0).empty());
}

}  // namespace
}  // namespace hapton
