#include "tools/live/top_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "runtime/report.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TopSnapshot snapshot_after(double seconds, int slow_samples) {
  LatencyReport report;
  report.program = "io_node";
  report.machine.host = "io-host";
  report.seconds = seconds;
  report.rates_hz = {{"servo_requested", 1000.0}};
  const auto samples = static_cast<std::int64_t>(1000 * seconds);
  report.counters = {{"samples", samples}, {"lost", 2 * static_cast<std::int64_t>(seconds)}, {"clamped", 0}, {"bytes_sent", 100 * samples}};
  report.notes = {{"device", "simulated"}};
  report.nodes = {{"haptics", "10.0.0.2:4444", seconds, samples, 2, 0, 0, samples, 0}};
  LatencyHop hop{"round_trip", {}};
  for (std::int64_t n = 0; n < samples; ++n) hop.histogram.record(20'000);
  for (int n = 0; n < slow_samples; ++n) hop.histogram.record(700'000);
  report.hops = {hop};
  return *read_top_snapshot(to_json(report), to_csv(report));
}

TEST(TopView, ShowsWhatHasBeenSinceTheStart) {
  const std::string view = make_top_view("io-host:4950", snapshot_after(10, 0), nullptr);
  EXPECT_THAT(view, HasSubstr("hub io-host:4950 on io-host: up 10 s, device simulated, servo 1000.0 Hz of 1000 Hz requested"));
  EXPECT_THAT(view, HasSubstr("100.0 kB/s"));
  EXPECT_THAT(view, HasSubstr("haptics   10.0.0.2:4444"));
  EXPECT_THAT(view, HasSubstr("round_trip             10000      20"));
  EXPECT_THAT(view, HasSubstr("lost"));
  EXPECT_THAT(view, Not(HasSubstr("clamped")));
}

TEST(TopView, IsOneLineOfJsonForPrograms) {
  const TopSnapshot before = snapshot_after(10, 0);
  const std::string line = make_top_json("io-host:4950", snapshot_after(14, 0), &before, "car");
  EXPECT_EQ(std::ranges::count(line, '\n'), 1);
  const auto snapshot = nlohmann::json::parse(line);
  EXPECT_EQ(snapshot["schema"], "hapton.top/1");
  EXPECT_EQ(snapshot["hub"], "io-host:4950");
  EXPECT_EQ(snapshot["touched"], "car");
  EXPECT_EQ(snapshot["span_s"], 4.0);
  EXPECT_EQ(snapshot["per_second"]["samples"], 1000.0);
  EXPECT_EQ(snapshot["per_second"]["clamped"], 0.0);
  EXPECT_EQ(snapshot["report"]["counters"]["samples"], 14'000);
  EXPECT_EQ(snapshot["report"]["nodes"][0]["role"], "haptics");
  EXPECT_EQ(nlohmann::json::parse(make_top_json("h", before, nullptr))["span_s"], 10.0);
}

TEST(TopView, SaysWhatTheGovernorDoes) {
  TopSnapshot snapshot = snapshot_after(10, 0);
  EXPECT_THAT(make_top_view("h", snapshot, nullptr), Not(HasSubstr("safety governor")));
  snapshot.report["notes"]["governor"] = "live";
  snapshot.report["ratios"] = {{"thermal_load", 0.123}, {"energy_spent", -0.05}};
  EXPECT_THAT(make_top_view("h", snapshot, nullptr), HasSubstr("safety governor live; thermal load 12 %, energy 0 % of its budget\n"));
  snapshot.report["notes"]["governor"] = "latched";
  snapshot.report["notes"]["safety_fault_text"] = "the motors are too hot";
  EXPECT_THAT(make_top_view("h", snapshot, nullptr),
              HasSubstr("safety governor latched: the motors are too hot; hapton set --reset-faults;"));
}

TEST(TopView, SaysWhyThereIsNoForce) {
  TopSnapshot snapshot = snapshot_after(10, 0);
  snapshot.report["notes"]["status_now"] = "ok";
  EXPECT_THAT(make_top_view("h", snapshot, nullptr), Not(HasSubstr("ok\n")));
  snapshot.report["notes"]["status_now"] = "no force: the device is away";
  EXPECT_THAT(make_top_view("h", snapshot, nullptr), HasSubstr("\nno force: the device is away\n"));
}

TEST(TopView, SaysWhatIsTouched) {
  EXPECT_THAT(make_top_view("h", snapshot_after(10, 0), nullptr), Not(HasSubstr("touching")));
  EXPECT_THAT(make_top_view("h", snapshot_after(10, 0), nullptr, "touching hood (tin)"), HasSubstr("\n\ntouching hood (tin)\n\n"));
}

TEST(TopView, BetweenTwoSnapshotsShowsWhatIsNew) {
  const TopSnapshot before = snapshot_after(100, 0);
  const TopSnapshot now = snapshot_after(102, 2000);
  const std::string view = make_top_view("h", now, &before);
  // Half of the 4,000 new round trips are slow; of all 104,000, only a few are.
  EXPECT_THAT(view, HasSubstr("round_trip              4000"));
  EXPECT_THAT(view, HasSubstr("servo 1000.0 Hz"));
  EXPECT_THAT(view, HasSubstr("+4\n"));
  EXPECT_THAT(make_top_view("h", now, nullptr), Not(HasSubstr("+4\n")));
}

TEST(TopView, RatesOfANodeAreThoseBetweenTwoSnapshots) {
  const TopSnapshot before = snapshot_after(100, 0);
  TopSnapshot now = snapshot_after(102, 0);
  now.report["nodes"][0]["received"] = 106'000;
  now.report["nodes"][0]["sent"] = 101'000;
  EXPECT_THAT(make_top_view("h", now, &before), HasSubstr("10.0.0.2:4444                      3000.0        500.0 "));
}

// The node has the same address, but its counts have begun at zero again.
TEST(TopView, ANodeThatJoinedAgainIsShownFromThen) {
  const TopSnapshot before = snapshot_after(100, 0);
  TopSnapshot now = snapshot_after(105, 0);
  now.report["nodes"][0]["seconds"] = 2.0;
  now.report["nodes"][0]["received"] = 5'000;
  now.report["nodes"][0]["sent"] = 4'000;
  EXPECT_THAT(make_top_view("h", now, &before), HasSubstr("10.0.0.2:4444                      2500.0       2000.0 "));
}

TEST(TopView, AHubThatBeganAgainIsShownFromItsStart) {
  const TopSnapshot before = snapshot_after(100, 0);
  EXPECT_EQ(make_top_view("h", snapshot_after(2, 0), &before), make_top_view("h", snapshot_after(2, 0), nullptr));
}

TEST(TopView, RubbishIsNamedAndAnEmptyReportShown) {
  EXPECT_FALSE(read_top_snapshot("hello", ""));
  EXPECT_FALSE(read_top_snapshot("{\"schema\": \"other\"}", ""));
  const auto empty = read_top_snapshot("{\"schema\": \"hapton.report/4\"}", "");
  ASSERT_TRUE(empty);
  EXPECT_THAT(make_top_view("h", *empty, nullptr), HasSubstr("no node has joined"));
}

}  // namespace
}  // namespace hapton
