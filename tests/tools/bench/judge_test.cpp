#include "tools/bench/judge.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <memory>
#include <utility>

#include "core/geometry/mesh_shapes.h"

namespace hapton {
namespace {

TouchScene bumps() {
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(make_bumpy_sphere(0.045, 0.2, 1000, 3)), Material{}});
  return scene;
}

TEST(Judge, ThreadsChangeNothing) {
  const TouchScene scene = bumps();
  const auto trajectory = make_tap_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 400});
  MethodSettings settings;
  settings.name = "reference";
  const auto one = run_method(settings, scene, *trajectory, 1);
  const auto many = run_method(settings, scene, *trajectory, 3);
  ASSERT_TRUE(one.has_value() && many.has_value());
  int contacts = 0;
  for (std::size_t i = 0; i < one->size(); ++i) {
    ASSERT_EQ((*one)[i].force_n, (*many)[i].force_n);
    contacts += (*one)[i].force_n.norm() > 0.0;
  }
  EXPECT_GT(contacts, 50);
}

TEST(Judge, ReferenceAgainstItselfHasNoError) {
  const TouchScene scene = bumps();
  const auto trajectory = make_slide_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 600});
  JudgeSettings settings;
  settings.method.name = "reference";
  const auto judged = judge_method(settings, scene, *trajectory);
  ASSERT_TRUE(judged.has_value());
  EXPECT_EQ(judged->error.error.most, 0.0);
  EXPECT_GT(judged->error.contact_steps, 300u);
  EXPECT_EQ(judged->error.falls + judged->error.locks + judged->error.pops + judged->error.ghosts, 0u);
  EXPECT_THAT(to_text(*judged), ::testing::HasSubstr("falls 0"));
  EXPECT_THAT(to_json(*judged), ::testing::HasSubstr("\"branch_switches\""));
}

TEST(Judge, ProxyIsWithinATenthOfAPercentInAllButAHundredthOfTheSteps) {
  const TouchScene scene = bumps();
  const auto trajectory = make_slide_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 1000});
  JudgeSettings settings;
  settings.method.name = "proxy";
  const auto judged = judge_method(settings, scene, *trajectory);
  ASSERT_TRUE(judged.has_value());
  EXPECT_LT(judged->error.error.p99, 1e-3);
  EXPECT_EQ(judged->error.falls, 0u);
}

TEST(Judge, AShadedForceIsJudgedByTheUnshadedReferenceAndSaysSo) {
  const TouchScene scene = bumps();
  const auto trajectory = make_slide_trajectory(*scene.objects[0].mesh, {.seed = 4, .rows = 600});
  JudgeSettings settings;
  const auto plain = judge_method(settings, scene, *trajectory);
  settings.method.shading = 1.0;
  const auto shaded = judge_method(settings, scene, *trajectory);
  ASSERT_TRUE(plain.has_value() && shaded.has_value());
  for (std::size_t i = 0; i < plain->reference.size(); ++i) {
    ASSERT_EQ(shaded->reference[i].force_n, plain->reference[i].force_n);
    ASSERT_EQ(shaded->method[i].proxy, plain->method[i].proxy);
  }
  EXPECT_GT(shaded->error.direction_rad.p50, 10.0 * plain->error.direction_rad.p50);
  EXPECT_THAT(to_text(*shaded), ::testing::HasSubstr("force shading 1: the shaded force against the unshaded reference"));
  EXPECT_THAT(to_json(*shaded), ::testing::HasSubstr("\"shading\": 1.0"));
  EXPECT_THAT(to_json(*shaded), ::testing::HasSubstr("\"reference_shading\": 0.0"));
  EXPECT_THAT(to_text(*plain), ::testing::Not(::testing::HasSubstr("shading")));
}

TEST(Judge, SaysWhyAMethodCannotRun) {
  MethodSettings settings;
  settings.name = "no such method";
  EXPECT_FALSE(run_method(settings, bumps(), TouchTrajectory{.p_SD = {Vec3::Zero()}}, 1).has_value());
}

}  // namespace
}  // namespace hapton
