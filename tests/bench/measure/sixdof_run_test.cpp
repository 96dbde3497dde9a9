#include "bench/measure/sixdof_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr TimingBudget kOneRepetition{.repetitions = 1, .seconds = 0.0};

TEST(SixdofRun, ForcesAndTorquesAreWithinOnePercentOfTheoryAndNothingPenetrates) {
  const Stopwatch watch = Stopwatch::calibrate();
  for (const SixdofScenario& scenario : make_analytic_scenarios(400)) {
    const auto row = measure_scenario(scenario, proxy_tool(), watch, kOneRepetition);
    ASSERT_TRUE(row) << row.error().what;
    EXPECT_GT(row->contact_steps, 100U) << row->name;
    EXPECT_LT(row->force_error_percent, 1.0) << row->name;
    EXPECT_LT(row->force_angle_deg, 1.0) << row->name;
    EXPECT_LT(row->torque_error_percent, 1.0) << row->name;
    EXPECT_LT(row->torque_angle_deg, 1.0) << row->name;
    EXPECT_EQ(row->penetrations, 0U) << row->name;
    EXPECT_GE(row->least_gap, ToolProxy::kMinGap) << row->name;
  }
}

TEST(SixdofRun, TheForceTaskIsAsNearToTheoryWithAPoseEachSample) {
  const Stopwatch watch = Stopwatch::calibrate();
  for (const SixdofScenario& scenario : make_analytic_scenarios(400)) {
    const auto row = measure_scenario(scenario, force_task(1), watch, kOneRepetition);
    ASSERT_TRUE(row) << row.error().what;
    EXPECT_EQ(row->method, "force");
    EXPECT_GT(row->contact_steps, 100U) << row->name;
    EXPECT_LT(row->force_error_percent, 1.0) << row->name;
    EXPECT_LT(row->force_angle_deg, 1.0) << row->name;
    EXPECT_EQ(row->penetrations, 0U) << row->name;
  }
}

TEST(SixdofRun, TheForceTaskErrsWhereThePoseIsRare) {
  const SixdofScenario scenario = make_analytic_scenarios(400).front();
  const auto row = measure_scenario(scenario, force_task(200), Stopwatch::calibrate(), kOneRepetition);
  ASSERT_TRUE(row);
  EXPECT_EQ(row->method, "force, 200 ms");
  EXPECT_GT(row->force_error_percent, 10.0) << "contacts come late, and age";
}

// Voxels keep the tool tenths of a millimetre away from the scene, so their force is wrong by some percent.
TEST(SixdofRun, VoxelsAreFartherFromTheory) {
  const SixdofScenario scenario = make_analytic_scenarios(1200).front();
  const auto row = measure_scenario(scenario, voxel_tool(1e-3), Stopwatch::calibrate(), kOneRepetition);
  ASSERT_TRUE(row);
  EXPECT_EQ(row->method, "voxels, 1 mm");
  EXPECT_GT(row->contact_steps, 300U);
  EXPECT_GT(row->force_error_percent, 1.0);
  EXPECT_GT(row->widest_gap_um, 100.0);
}

TEST(SixdofRun, AWrongWrenchIsAnError) {
  const Stopwatch watch = Stopwatch::calibrate();
  SixdofScenario scenario = make_analytic_scenarios(400).front();
  scenario.expected = [right = scenario.expected](const Pose& X) {
    Wrench6 wrench = right(X);
    wrench.force_n *= 1.1;
    wrench.force_n.x() += 0.1 * wrench.force_n.z();
    return wrench;
  };
  const auto row = measure_scenario(scenario, proxy_tool(), watch, kOneRepetition);
  ASSERT_TRUE(row);
  EXPECT_GT(row->force_error_percent, 5.0);
  EXPECT_GT(row->force_angle_deg, 3.0);
}

// The computed force counts as an error in the steps that expect none, too; these steps have no angle.
TEST(SixdofRun, AForceThatIsNotExpectedIsAnError) {
  SixdofScenario scenario = make_analytic_scenarios(400).front();
  scenario.expected = [right = scenario.expected, is_odd = false](const Pose& X) mutable {
    is_odd = !is_odd;
    return is_odd ? right(X) : Wrench6{};
  };
  const auto row = measure_scenario(scenario, proxy_tool(), Stopwatch::calibrate(), kOneRepetition);
  ASSERT_TRUE(row);
  EXPECT_NEAR(row->force_error_percent, 100.0, 10.0);
  EXPECT_LT(row->force_angle_deg, 1.0);
}

TEST(SixdofRun, APegIsNeverNearerThanHalfTheOffset) {
  const auto row = measure_scenario(make_peg_scenario(2500, 7), proxy_tool(), Stopwatch::calibrate(), kOneRepetition);
  ASSERT_TRUE(row);
  EXPECT_GT(row->contact_steps, 1000U);
  EXPECT_EQ(row->penetrations, 0U);
  EXPECT_GE(row->least_gap, ToolProxy::kMinGap);
}

TEST(SixdofRun, TheReportNamesEachScenario) {
  SixdofReport report;
  SixdofRow row;
  row.name = "box on plane";
  row.method = "proxy";
  row.has_errors = true;
  row.force_error_percent = 0.25;
  report.rows = {row};
  EXPECT_THAT(to_csv(report), testing::HasSubstr("\"box on plane\",\"proxy\",0,0.25,"));
  EXPECT_THAT(to_json(report), testing::HasSubstr("\"force_error_percent\": 0.25"));
  EXPECT_THAT(to_text(report), testing::HasSubstr("box on plane"));
  EXPECT_THAT(to_text(report), testing::HasSubstr("more than 200,000 triangles, where it is not measured"));
}

}  // namespace
}  // namespace hapton
