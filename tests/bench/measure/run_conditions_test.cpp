#include "bench/measure/run_conditions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

RunConditions on_four_cpus(double load_before, double load_after) {
  RunConditions conditions;
  conditions.machine.cpu_count = 4;
  conditions.load_before = load_before;
  conditions.load_after = load_after;
  return conditions;
}

TEST(RunConditions, TheMachineWasSharedIfThereWasMoreLoadThanCpusBeforeOrAfter) {
  EXPECT_FALSE(on_four_cpus(1.0, 2.0).was_shared());
  EXPECT_FALSE(on_four_cpus(4.0, 4.0).was_shared());
  EXPECT_TRUE(on_four_cpus(4.5, 1.0).was_shared());
  EXPECT_TRUE(on_four_cpus(1.0, 4.5).was_shared());
}

TEST(RunConditions, TheTextWarnsOfWhatMakesTheTimesDoubtful) {
  RunConditions good = on_four_cpus(1.0, 2.0);
  good.clock_drift = 0.01;
  EXPECT_THAT(good.to_text(), HasSubstr("load 1.0 before, 2.0 after"));
  EXPECT_THAT(good.to_text(), Not(HasSubstr("other programs were running")));
  EXPECT_THAT(good.to_text(), Not(HasSubstr("do not trust these times")));
  EXPECT_THAT(good.to_text(), Not(HasSubstr("not built")));
  RunConditions bad = on_four_cpus(1.0, 5.0);
  bad.clock_drift = 0.02;
  bad.missing_peers = {"embree", "cgal"};
  EXPECT_THAT(bad.to_text(), HasSubstr("other programs were running"));
  EXPECT_THAT(bad.to_text(), HasSubstr("drifts by 2.0 %: do not trust these times"));
  EXPECT_THAT(bad.to_text(), HasSubstr("; not built: embree, cgal"));
}

TEST(RunConditions, TheReportHasThem) {
  RunConditions conditions = on_four_cpus(1.0, 5.0);
  conditions.seed = 7;
  conditions.clock_cost_ns = 8.0;
  conditions.clock_resolution_ns = 9.0;
  conditions.clock_drift = 0.02;
  conditions.seconds = 11.0;
  conditions.missing_peers = {"embree"};
  const auto json = to_json(conditions, "hapton bench effects");
  EXPECT_EQ(json.at("schema"), kBenchSchema);
  EXPECT_EQ(json.at("program"), "hapton bench effects");
  EXPECT_EQ(json.at("machine").at("cpu_count"), 4);
  EXPECT_EQ(json.at("seed"), 7);
  EXPECT_EQ(json.at("load_before"), 1.0);
  EXPECT_EQ(json.at("load_after"), 5.0);
  EXPECT_EQ(json.at("machine_was_shared"), true);
  EXPECT_EQ(json.at("clock_cost_ns"), 8.0);
  EXPECT_EQ(json.at("clock_resolution_ns"), 9.0);
  EXPECT_EQ(json.at("clock_drift"), 0.02);
  EXPECT_EQ(json.at("seconds"), 11.0);
  EXPECT_EQ(json.at("not_built").at(0), "embree");
}

}  // namespace
}  // namespace hapton
