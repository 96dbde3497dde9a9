#include "tools/bench/tool_stress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

TEST(ToolStress, HasNoFaultOnAFewBodies) {
  std::vector<StressBody> bodies;
  for (const char* name : {"box", "gutter", "sphere"}) {
    StressBody body = make_stress_body(name);
    ASSERT_FALSE(body.touched.triangles.empty()) << name;
    bodies.push_back(std::move(body));
  }
  ToolStressPlan plan;
  plan.steps = 6000;
  plan.scales = {1e-6, 1.0, 1e6};
  const auto results = run_tool_stress(bodies, plan, [](const ToolStressResult&) {});
  ASSERT_TRUE(results) << results.error().what;
  std::uint64_t contact_steps = 0;
  for (const ToolStressResult& result : *results) {
    EXPECT_EQ(result.count.faults(), 0U) << to_text(*results);
    contact_steps += result.count.contact_steps;
  }
  EXPECT_GT(contact_steps, 1000U);
}

TEST(ToolStress, HasNoFaultOnBodiesThatMove) {
  std::vector<StressBody> bodies;
  for (const std::size_t n : {0, 1}) bodies.push_back(make_stress_body(std::string(stress_body_names()[n])));
  ToolStressPlan plan;
  plan.steps = 6000;
  plan.scales = {1e-6, 1.0, 1e6};
  plan.moving = true;
  const auto results = run_tool_stress(bodies, plan, [](const ToolStressResult&) {});
  ASSERT_TRUE(results) << results.error().what;
  std::uint64_t contact_steps = 0;
  std::uint64_t squeezed_steps = 0;
  for (const ToolStressResult& result : *results) {
    EXPECT_EQ(result.count.faults(), 0U) << to_text(*results);
    contact_steps += result.count.contact_steps;
    squeezed_steps += result.count.squeezed;
  }
  EXPECT_GT(contact_steps, 1000U);
  EXPECT_GT(squeezed_steps, 0U);
}

// Even with only one episode for each body and tool, a quarter of the episodes begin inside the body.
TEST(ToolStress, AShortRunBeginsInsideTooAndFindsOverlaps) {
  std::vector<StressBody> bodies;
  for (const std::string_view name : stress_body_names()) {
    if (bodies.size() < 6) bodies.push_back(make_stress_body(std::string(name)));
  }
  ToolStressPlan plan;
  plan.steps = 1;
  plan.scales = {1.0};
  const auto results = run_tool_stress(bodies, plan, [](const ToolStressResult&) {});
  ASSERT_TRUE(results) << results.error().what;
  std::uint64_t overlaps = 0;
  for (const ToolStressResult& result : *results) {
    EXPECT_EQ(result.count.faults(), 0U) << to_text(*results);
    overlaps += result.count.overlaps;
  }
  EXPECT_GT(overlaps, 0U);
}

TEST(ToolStress, AFaultIsNamedInTheTable) {
  ToolStressResult result{.body = "box", .count = {}};
  result.count.penetrations = 3;
  result.count.first_fault = "tool ball, scale 1, episode 5";
  EXPECT_EQ(result.count.faults(), 3U);
  EXPECT_THAT(to_text({result}), testing::HasSubstr("first: tool ball, scale 1, episode 5"));
}

}  // namespace
}  // namespace hapton
