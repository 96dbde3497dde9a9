#include "tools/bench/stress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

StressPlan small_plan(unsigned threads) {
  StressPlan plan;
  plan.method.name = "reference";
  plan.method.reference_substeps = 1;
  plan.steps = 1200;
  plan.threads = threads;
  plan.variants = {{.scale = 1.0}, {.scale = 1e-3}, {.offset_extents = 10.0}};
  return plan;
}

TEST(Stress, RunsEveryBodyInEveryVariantWhateverTheThreads) {
  const std::vector<StressBody> bodies{make_stress_body("box"), make_stress_body("tetrahedron")};
  std::size_t printed = 0;
  const auto one = run_stress(bodies, small_plan(1), [&](const StressResult&) { ++printed; });
  const auto many = run_stress(bodies, small_plan(3), [](const StressResult&) {});
  ASSERT_TRUE(one.has_value() && many.has_value());
  EXPECT_EQ(printed, 6u);
  ASSERT_EQ(one->size(), 6u);
  for (std::size_t i = 0; i < one->size(); ++i) {
    EXPECT_EQ((*one)[i].count.steps, (*many)[i].count.steps);
    EXPECT_EQ((*one)[i].count.contact_steps, (*many)[i].count.contact_steps);
    EXPECT_GE((*one)[i].count.steps, 400u);
  }
  EXPECT_EQ(sum_of(*one).total_faults(), 0u);
}

TEST(Stress, FindingsComeWithTheCommandThatShowsThemAgain) {
  StressResult result{"box", {.scale = 1e-3}, {}};
  result.count.faults[0] = 1;
  result.count.findings = {{.fault = StressFault::fall_through, .motion = StressMotion::tap_edge, .episode = 77, .step = 5, .size = 0.01}};
  const std::string text = to_text({result}, small_plan(1));
  EXPECT_THAT(text, ::testing::HasSubstr("fall_through in tap-edge at step 5"));
  EXPECT_THAT(text, ::testing::HasSubstr("--body box --seed 1 --scale 0.001"));
  EXPECT_THAT(text, ::testing::HasSubstr("--episode 77"));
  EXPECT_THAT(to_json({result}, small_plan(1)), ::testing::HasSubstr("\"faults\": 1"));
  EXPECT_THAT(text, ::testing::Not(::testing::HasSubstr("--no-seal")));
  StressPlan unsealed = small_plan(1);
  unsealed.no_seal = true;
  EXPECT_THAT(to_text({result}, unsealed), ::testing::HasSubstr("--no-seal"));
}

TEST(Stress, WhatWasNotLookedForIsNoZero) {
  const auto results = run_stress({make_stress_body("tetrahedron")}, small_plan(1), [](const StressResult&) {});
  ASSERT_TRUE(results.has_value());
  EXPECT_THAT(to_text(*results, small_plan(1)), ::testing::ContainsRegex("tetrahedron +[0-9]+ +[0-9]+ +[0-9]+ +0 +0 +- +0 +0 +- +0 +0\n"));
  EXPECT_THAT(to_text(*results, small_plan(1)), ::testing::HasSubstr("discontinuity   the force changed by more than"));
  const std::string json = to_json(*results, small_plan(1));
  EXPECT_THAT(json, ::testing::HasSubstr("\"discontinuity\": null"));
  EXPECT_THAT(json, ::testing::HasSubstr("\"fall_through\": 0"));
}

TEST(Stress, LongWalksComeOnTopWhereAVariantGetsTenThousandSteps) {
  StressPlan plan = small_plan(1);
  plan.method.name = "proxy";
  plan.compare_every = 0;
  plan.variants.resize(1);
  plan.steps = 10000;
  const auto steps_of = [&] { return sum_of(*run_stress({make_stress_body("box")}, plan, [](const StressResult&) {})).steps; };
  EXPECT_GE(steps_of(), 30000U);
  plan.steps = 9999;
  EXPECT_LT(steps_of(), 10400U);
}

TEST(Stress, RejectsAnUnknownMethod) {
  StressPlan plan = small_plan(1);
  plan.method.name = "no such method";
  EXPECT_FALSE(run_stress({make_stress_body("box")}, plan, [](const StressResult&) {}).has_value());
}

}  // namespace
}  // namespace hapton
