#include "tools/latency/report_upgrade.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "runtime/report.h"

namespace hapton {
namespace {

using Json = nlohmann::ordered_json;

TEST(ReportUpgrade, GivesTheOldSchemaTheNewNames) {
  Json report = {{"schema", "hapton.report/1"},
                 {"counters", {{"samples", 10}, {"silence_events", 3}, {"let_go_of", 2}}},
                 {"notes", {{"device", "simulated"}, {"safety_fault_is", "too hot"}}}};
  upgrade_report(report);
  EXPECT_EQ(report["schema"], kReportSchema);
  EXPECT_EQ(report["counters"], (Json{{"samples", 10}, {"command_timeouts", 3}, {"dead_mans_switch_releases", 2}}));
  EXPECT_EQ(report["notes"], (Json{{"device", "simulated"}, {"safety_fault_text", "too hot"}}));
}

TEST(ReportUpgrade, GivesTheSecondSchemaTheNewNames) {
  Json report = {
      {"schema", "hapton.report/2"}, {"counters", {{"samples", 10}}}, {"rates_hz", {{"servo_asked", 1000.0}, {"samples", 999.9}}}};
  upgrade_report(report);
  EXPECT_EQ(report["schema"], kReportSchema);
  EXPECT_EQ(report["rates_hz"], (Json{{"samples", 999.9}, {"servo_requested", 1000.0}}));
}

TEST(ReportUpgrade, GivesTheThirdSchemaTheNewNames) {
  Json report = {{"schema", "hapton.report/3"},
                 {"counters",
                  {{"unanswered_without_haptics", 1},
                   {"echo_answered", 2},
                   {"device_cuts", 3},
                   {"budget_spent", 4},
                   {"markers_refused", 5},
                   {"near_throttling", 6},
                   {"late", 7}}}};
  upgrade_report(report);
  EXPECT_EQ(report["schema"], kReportSchema);
  EXPECT_EQ(nlohmann::json(report["counters"]), (nlohmann::json{{"no_reply_without_haptics", 1},
                                                                {"echo_replied", 2},
                                                                {"device_releases", 3},
                                                                {"datagram_budget_exhausted", 4},
                                                                {"markers_rejected", 5},
                                                                {"near_rt_throttling", 6},
                                                                {"late", 7}}));
}

TEST(ReportUpgrade, LeavesAnyOtherAsItIs) {
  const std::vector<Json> others = {{{"schema", kReportSchema}, {"counters", {{"silence_events", 3}}}},
                                    {{"schema", "hapton.report/9"}},
                                    {{"schema", 1}},
                                    Json::array({1, 2}),
                                    {{"schema", "hapton.report/1"}, {"counters", 7}}};
  for (const Json& other : others) {
    Json upgraded = other;
    upgrade_report(upgraded);
    if (upgraded.is_object()) upgraded["schema"] = other["schema"];
    EXPECT_EQ(upgraded, other);
  }
}

}  // namespace
}  // namespace hapton
