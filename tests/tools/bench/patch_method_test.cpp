#include "tools/bench/patch_method.h"

#include <gtest/gtest.h>

#include "core/force/evaluation/stress_run.h"
#include "tools/bench/stress.h"

namespace hapton {
namespace {

// The numerical stress test of every body, felt by patches of its parts: no fault of any kind, with friction and without.
TEST(PatchMethod, HoldsTheStressTestOfEveryBody) {
  StressPlan plan;
  plan.by_patches = true;
  plan.variants = patch_variants();
  plan.steps = 1000;
  plan.seed = 3;
  plan.threads = 2;
  std::vector<StressBody> bodies;
  for (const std::string_view name : stress_body_names()) bodies.push_back(make_stress_body(name));
  const auto results = run_stress(bodies, plan, [](const StressResult&) {});
  ASSERT_TRUE(results) << results.error().what;
  EXPECT_EQ(sum_of(*results).total_faults(), 0U) << to_text(*results, plan);
  EXPECT_GT(sum_of(*results).contact_steps, 20000U);
}

// Otherwise the test above says nothing of patches that take over from one another.
TEST(PatchMethod, TakesManyPatchesForALongWay) {
  const StressBody body = on_patch_grid(make_stress_body("bumpy"));
  TouchScene scene;
  scene.objects.push_back({std::make_shared<TriangleMesh>(body.touched), Material()});
  PatchMethod method({}, scene);
  method.reset(Vec3(0.06, 0.0, 0.0));
  for (int n = 0; n < 2000; ++n) {
    const double angle = 0.005 * n;
    (void)method.step({0.045 * Vec3(std::cos(angle), std::sin(angle), 0.3 * std::sin(3.0 * angle)), 1e-3});
  }
  EXPECT_GT(method.counts().handed_over, 20U);
  EXPECT_GT(method.counts().contact_steps, 1000U);
}

}  // namespace
}  // namespace hapton
