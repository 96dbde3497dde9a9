#include "tools/bench/patch_method.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

#include "core/force/evaluation/stress_run.h"
#include "tools/bench/stress.h"

namespace hapton {
namespace {

StressPlan short_plan(bool by_patches) {
  StressPlan plan;
  plan.by_patches = by_patches;
  plan.variants = patch_variants();
  plan.steps = 1000;
  plan.seed = 3;
  plan.threads = 2;
  return plan;
}

// The numerical stress test of every body on its grid, with friction and without. Touched by patches of its parts, a body has no more
// faults than when it is touched as a whole.
TEST(PatchMethod, HasNoMoreFaultsThanTheWholeBody) {
  std::vector<StressBody> bodies;
  for (const std::string_view name : stress_body_names()) bodies.push_back(on_patch_grid(make_stress_body(name)));
  const auto no_output = [](const StressResult&) {};
  const auto whole = run_stress(bodies, short_plan(false), no_output);
  const auto patched = run_stress(bodies, short_plan(true), no_output);
  ASSERT_TRUE(whole && patched);
  for (std::size_t i = 0; i < whole->size(); ++i) {
    EXPECT_LE((*patched)[i].count.total_faults(), (*whole)[i].count.total_faults()) << (*whole)[i].body;
  }
  EXPECT_EQ(sum_of(*patched).total_faults(), 0U) << to_text(*patched, short_plan(true));
  EXPECT_GT(sum_of(*patched).contact_steps, 20000U);
}

// If this were not so, the test above would say nothing about patches that take over from one another.
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
  EXPECT_GT(method.counts().contact_steps, 500U);
}

}  // namespace
}  // namespace hapton
