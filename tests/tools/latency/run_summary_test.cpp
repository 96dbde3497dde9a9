#include "tools/latency/run_summary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using Json = nlohmann::ordered_json;

Json make_report() {
  return {{"schema", "hapton.report/4"},
          {"seconds", 6.0},
          {"rates_hz", {{"samples", 1999.3}, {"servo_requested", 2000.0}}},
          {"counters",
           {{"samples", 12000},
            {"forces", 11900},
            {"contact_samples", 5371},
            {"late", 3},
            {"lost", 0},
            {"faults_latched", 0},
            {"command_timeouts", 0}}},
          {"notes", {{"max_force_written_n", "3.716"}}},
          {"hops", {{"round_trip", {{"p50_us", 42.2}, {"p99_us", 93.7}}}}}};
}

TEST(RunSummary, OfAGoodRunSaysWhatWasTouchedAndThatItHeld) {
  const RunSummary summary = summarise_run(make_report(), "car.toml");
  EXPECT_TRUE(summary.has_contact);
  EXPECT_TRUE(summary.has_no_troubles);
  EXPECT_EQ(summary.text,
            "touched car.toml for 6.0 s: 5371 of 12000 samples in contact, at most 3.716 N\n"
            "it ran without faults: 1999 samples a second, no force lost, 3 late, round trip 42 us (p50), 94 us (p99)\n");
}

TEST(RunSummary, HasTheTorqueWhereThereWasOne) {
  Json report = make_report();
  report["notes"]["max_torque_written_nm"] = "0.0000";
  EXPECT_THAT(summarise_run(report, "pegs.toml").text, HasSubstr("at most 3.716 N\n"));
  report["notes"]["max_torque_written_nm"] = "0.0412";
  EXPECT_THAT(summarise_run(report, "pegs.toml").text, HasSubstr("at most 3.716 N and 0.0412 Nm\n"));
}

TEST(RunSummary, SaysWhenNothingWasTouched) {
  Json report = make_report();
  report["counters"]["contact_samples"] = 0;
  const RunSummary summary = summarise_run(report, "part.stl");
  EXPECT_FALSE(summary.has_contact);
  EXPECT_THAT(summary.text, HasSubstr("touched nothing of part.stl in 6.0 s"));
}

TEST(RunSummary, SaysThatTheDeviceCannotReachTheScene) {
  Json report = make_report();
  report["counters"]["contact_samples"] = 0;
  report["notes"]["reach"] = "the scene is out of the device's reach";
  const RunSummary summary = summarise_run(report, "part.stl");
  EXPECT_FALSE(summary.has_no_troubles);
  EXPECT_THAT(summary.text, HasSubstr("out of the device's reach (check --unit and --no-fit)"));
}

TEST(RunSummary, NamesEachThingThatDidNotHold) {
  struct Case {
    const char *section, *key;
    double value;
    const char* expected_text;
  };
  for (const Case& c :
       {Case{"counters", "lost", 2, "2 forces lost"}, Case{"counters", "faults_latched", 1, "1 fault latched"},
        Case{"counters", "command_timeouts", 4, "4 command timeouts"}, Case{"counters", "command_timeouts", 1, "1 command timeout,"},
        Case{"counters", "late", 120, "120 forces late"}, Case{"counters", "forces", 0, "no force came back"},
        Case{"rates_hz", "samples", 1979, "1979 samples a second of 2000"}}) {
    Json report = make_report();
    report[c.section][c.key] = c.value;
    const RunSummary summary = summarise_run(report, "x");
    EXPECT_FALSE(summary.has_no_troubles) << c.key;
    EXPECT_THAT(summary.text, HasSubstr(c.expected_text));
    EXPECT_THAT(summary.text, HasSubstr("it had faults"));
  }
}

TEST(RunSummary, OfAReportWithoutTheKeysClaimsNothing) {
  const RunSummary summary = summarise_run(Json{{"schema", "hapton.report/4"}, {"hops", Json::object()}}, "x");
  EXPECT_FALSE(summary.has_contact);
  EXPECT_FALSE(summary.has_no_troubles);
  EXPECT_THAT(summary.text, Not(HasSubstr("round trip")));
}

TEST(RunSummary, AValueOfAnotherTypeCountsAsNone) {
  Json report = make_report();
  report["seconds"] = "long";
  report["notes"] = {{"max_force_written_n", 3.7}, {"reach", Json::array()}};
  EXPECT_THAT(summarise_run(report, "x").text, HasSubstr("touched x for 0.0 s"));
}

}  // namespace
}  // namespace hapton
