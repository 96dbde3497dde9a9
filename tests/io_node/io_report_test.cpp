#include "io_node/io_report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>

#include "runtime/prometheus_text.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

std::unique_ptr<ServoStats> stats_of_two_seconds() {
  auto stats = std::make_unique<ServoStats>();
  stats->start_ns = 5'000'000'000;
  stats->end_ns = 7'000'000'000;
  stats->rate_hz = 1000.0;
  stats->samples = 1990;
  stats->forces = 1900;
  stats->contact_samples = 700;
  stats->missed_cycles = 10;
  stats->responses.lost = 3;
  stats->hub.undecodable = 2;
  stats->hub.unknown_peers = 5;
  stats->local_forces = 40;
  stats->patch_thread.store.parts = 12;
  stats->patch_thread.built = 6;
  stats->patch_touch.handed_over = 4;
  stats->patch_touch.beyond = 2;
  stats->patch_touch.beyond_steps = 30;
  for (int n = 0; n < 1000; ++n) {
    stats->round_trip.record(n < 950 ? 30'000 : 90'000);
    stats->bare_echo.record(n < 950 ? 20'000 : 30'000);
  }
  return stats;
}

TEST(IoReport, HoldsHopsRatesCountersAndTheRatioToTheBareEcho) {
  IoOptions options;
  options.echo_probe = "127.0.0.1:9";
  options.device.seed = 17;
  const LatencyReport report = make_io_report(*stats_of_two_seconds(), options, "real time: off");
  EXPECT_EQ(report.program, "io_node");
  EXPECT_EQ(report.seconds, 2.0);
  EXPECT_EQ(report.rates_hz.at("samples"), 995.0);
  EXPECT_EQ(report.counters.at("contact_samples"), 700);
  EXPECT_EQ(report.counters.at("lost"), 3);
  EXPECT_EQ(report.counters.at("datagrams_rejected"), 7);
  EXPECT_EQ(report.counters.at("local_forces"), 40);
  EXPECT_EQ(report.counters.at("patch_parts"), 12);
  EXPECT_EQ(report.counters.at("patches_built"), 6);
  EXPECT_EQ(report.counters.at("patches_taken_over"), 4);
  EXPECT_EQ(report.counters.at("beyond_patch"), 2);
  EXPECT_EQ(report.counters.at("beyond_patch_steps"), 30);
  EXPECT_EQ(report.notes.at("seed"), "17");
  EXPECT_NEAR(report.ratios.at("round_trip_over_echo_p50"), 1.5, 0.05);
  EXPECT_NEAR(report.ratios.at("round_trip_over_echo_p99"), 3.0, 0.1);
  ASSERT_EQ(report.hops.size(), 16U);
  EXPECT_EQ(report.hops.front().name, "wake_lateness");
  EXPECT_EQ(report.hops.back().name, "bare_echo");
}

TEST(IoReport, SaysWhatTheDeviceSaysOfItself) {
  auto stats = stats_of_two_seconds();
  stats->device_status = DeviceStatus::calibrating;
  stats->device = {.model = "Touch", .serial = "SN1", .firmware = "192", .is_calibrated = false, .motor_temperature = 0.25};
  const LatencyReport report = make_io_report(*stats, {}, "");
  EXPECT_EQ(report.notes.at("device_state"), "calibrating");
  EXPECT_EQ(report.notes.at("device_calibrated"), "no");
  EXPECT_EQ(report.notes.at("device_model"), "Touch");
  EXPECT_EQ(report.notes.at("device_serial"), "SN1");
  EXPECT_EQ(report.notes.at("device_firmware"), "192");
  EXPECT_EQ(report.notes.at("motor_temperature"), "0.250");
  EXPECT_FALSE(make_io_report(*stats_of_two_seconds(), {}, "").notes.contains("motor_temperature"));
}

TEST(IoReport, NamesTheOptionsWithWhichItWasStarted) {
  const LatencyReport bare = make_io_report(*stats_of_two_seconds(), {}, "");
  for (const char* note : {"name", "device_id", "device_file", "trajectory", "echo_probe", "echo_bytes", "reach"}) {
    EXPECT_FALSE(bare.notes.contains(note)) << note;
  }
  IoOptions options;
  options.name = "left";
  options.device.id = "SN1";
  options.device.file = "mine.toml";
  options.device.trajectory = "t.csv";
  options.echo_probe = "127.0.0.1:9";
  options.echo_bytes = 200;
  auto stats = stats_of_two_seconds();
  stats->reach = SceneReach::too_small;
  const LatencyReport report = make_io_report(*stats, options, "");
  EXPECT_EQ(report.notes.at("name"), "left");
  EXPECT_EQ(report.notes.at("device_id"), "SN1");
  EXPECT_EQ(report.notes.at("device_file"), "mine.toml");
  EXPECT_EQ(report.notes.at("trajectory"), "t.csv");
  EXPECT_EQ(report.notes.at("echo_probe"), "127.0.0.1:9");
  EXPECT_EQ(report.notes.at("echo_bytes"), "200");
  EXPECT_THAT(report.notes.at("reach"), HasSubstr("too small"));
}

TEST(IoReport, ASceneWhoseHashIsNotKnownYetIsNamedWithoutIt) {
  auto stats = stats_of_two_seconds();
  std::copy_n("/a/part.stl", 11, stats->setup.scene.begin());
  std::copy_n("name=proxy", 10, stats->setup.method.begin());
  const LatencyReport report = make_io_report(*stats, {}, "");
  EXPECT_EQ(report.notes.at("scene"), "/a/part.stl");
  EXPECT_EQ(report.notes.at("method"), "name=proxy");
  EXPECT_FALSE(report.notes.contains("scene_hash"));
}

TEST(IoReport, SaysWhichSceneWasTouchedAndWithWhat) {
  auto stats = stats_of_two_seconds();
  EXPECT_FALSE(make_io_report(*stats, {}, "").notes.contains("scene"));
  stats->setup.scene_hash = 0xBEEF;
  EXPECT_FALSE(make_io_report(*stats, {}, "").notes.contains("scene_shape_hash"));
  stats->scene_given_hash = 0xFACADE;
  stats->setup.scene_loading = 1 + 2 + 4 + (3U << 3U);  // known, sealed, fitted, in mm (proto/hapton.proto)
  std::copy_n("/a/part.stl", 11, stats->setup.scene.begin());
  std::copy_n("name=proxy", 10, stats->setup.method.begin());
  stats->status = ProbeStatus::device_away;
  stats->reach = SceneReach::out_of_reach;
  const LatencyReport report = make_io_report(*stats, {}, "");
  EXPECT_EQ(report.notes.at("scene"), "/a/part.stl");
  EXPECT_EQ(report.notes.at("scene_hash"), "000000000000beef");
  EXPECT_EQ(report.notes.at("scene_shape_hash"), "0000000000facade");
  EXPECT_EQ(report.notes.at("scene_unit"), "mm");
  EXPECT_EQ(report.notes.at("scene_sealed"), "yes");
  EXPECT_EQ(report.notes.at("scene_fitted"), "yes");
  EXPECT_EQ(report.notes.at("method"), "name=proxy");
  EXPECT_EQ(report.notes.at("status_now"), "no force: the device is away");
  EXPECT_THAT(report.notes.at("reach"), HasSubstr("out of the device's reach"));
}

TEST(IoReport, ClaimsNoEchoThatWasNotMeasured) {
  auto stats = stats_of_two_seconds();
  stats->bare_echo.clear();
  const LatencyReport report = make_io_report(*stats, {}, "");
  EXPECT_FALSE(report.ratios.contains("round_trip_over_echo_p50"));
  EXPECT_EQ(report.hops.size(), 15U);
  EXPECT_THAT(describe_run(*stats), ::testing::Not(HasSubstr("echo")));
}

TEST(IoReport, SaysWhatTheGovernorDoes) {
  auto stats = stats_of_two_seconds();
  stats->governor.state = GovernorState::latched;
  stats->governor.fault = SafetyFault::speed;
  stats->governor.counters.latched = 2;
  stats->governor.counters.resets = 1;
  stats->governor.thermal_load = 0.25;
  stats->governor.energy_spent_j = 0.05;
  stats->governor.energy_most_j = 0.2;
  const LatencyReport report = make_io_report(*stats, {}, "");
  EXPECT_EQ(report.notes.at("governor"), "latched");
  EXPECT_EQ(report.notes.at("safety_fault"), "speed");
  EXPECT_THAT(report.notes.at("safety_fault_text"), HasSubstr("faster"));
  EXPECT_EQ(report.counters.at("faults_latched"), 2);
  EXPECT_EQ(report.counters.at("faults_reset"), 1);
  EXPECT_EQ(report.ratios.at("fault_latched_now"), 1.0);
  EXPECT_EQ(report.ratios.at("thermal_load"), 0.25);
  EXPECT_EQ(report.ratios.at("energy_spent"), 0.25);
  EXPECT_THAT(describe_run(*stats), HasSubstr("faults: 2 latched, 1 reset"));
  stats->governor.fault = SafetyFault::none;
  EXPECT_EQ(make_io_report(*stats, {}, "").ratios.at("fault_latched_now"), 0.0);
}

TEST(IoReport, NamesTheNodesThatAreThereAndHowFarTheirClockIsOff) {
  auto stats = stats_of_two_seconds();
  PeerStats& haptics = stats->peers[0];
  haptics.present = true;
  haptics.role = NodeRole::haptics;
  haptics.address = {{0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 10, 0, 0, 2}, 4444};
  haptics.joined_ns = 6'000'000'000;
  haptics.sent = 1000;
  haptics.sequence.received = 990;
  haptics.sequence.lost = 10;
  stats->hops.is_offset_known = true;
  stats->hops.clock_offset_ns = -1'500'000;
  stats->hops.clock_error_ns = 20'000;
  const LatencyReport report = make_io_report(*stats, {}, "");
  ASSERT_EQ(report.nodes.size(), 1U);
  EXPECT_EQ(report.nodes[0].role, "haptics");
  EXPECT_EQ(report.nodes[0].address, "10.0.0.2:4444");
  EXPECT_EQ(report.nodes[0].seconds, 1.0);
  EXPECT_EQ(report.nodes[0].lost, 10);
  EXPECT_EQ(report.notes.at("haptics_clock_offset"), "-1500.0 us, within 20.0 us");
  EXPECT_EQ(report.notes.at("haptics_clock_offset_ns"), "-1500000");
  EXPECT_EQ(report.notes.at("haptics_clock_error_ns"), "20000");
}

TEST(IoReport, DescribesTheRunInLines) {
  const std::string text = describe_run(*stats_of_two_seconds());
  EXPECT_THAT(text, HasSubstr("1990 samples (995 Hz)"));
  EXPECT_THAT(text, HasSubstr("lost 3"));
  EXPECT_THAT(text, HasSubstr("missed cycles 10"));
}

TEST(IoReport, DescribesTheAgeAtEveryHop) {
  auto stats = stats_of_two_seconds();
  stats->hops.wire_out.record(12'000);
  stats->device_to_drawn.record(30'000'000);
  const std::string text = describe_run(*stats);
  for (const char* part : {"p99.9", "\nwire_out ", "\nround_trip ", "\nbare_echo ", "\ndevice_to_drawn "}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, HasSubstr("the round trip takes 1.50 times as long as the bare echo at p50, 2.99 times at p99"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("wire_back"))) << "it was not measured";
}

TEST(IoReport, NamesNoDurationWhereNothingWasMeasured) {
  const std::string text = describe_run(ServoStats{});
  EXPECT_THAT(text, HasSubstr("0 samples"));
  EXPECT_THAT(text, ::testing::Not(HasSubstr("p50")));
}

// Every metric, hop and name in the expressions of the dashboard is one that we export.
TEST(IoReport, TheDashboardUsesExportedMetricsOnly) {
  IoOptions options;
  options.echo_probe = "127.0.0.1:9";
  auto stats = stats_of_two_seconds();
  stats->peers[0].present = true;
  SchedulingStats scheduling;
  scheduling.is_known = true;
  const std::string exported = to_prometheus(make_io_report(*stats, options, "", scheduling));
  std::ifstream file(HAPTON_SOURCE_DIR "/deploy/grafana/hapton.json");
  const auto dashboard = nlohmann::json::parse(file, nullptr, false);
  ASSERT_TRUE(dashboard.is_object()) << "deploy/grafana/hapton.json";
  std::size_t count = 0;
  for (const auto& panel : dashboard.at("panels")) {
    for (const auto& target : panel.value("targets", nlohmann::json::array())) {
      const auto expression = target.at("expr").get<std::string>();
      const std::regex metric("hapton_[a-z_]+"), label("(hop|name)=\"([a-z0-9_]+)\"");
      for (std::sregex_iterator match(expression.begin(), expression.end(), metric), end; match != end; ++match) {
        ++count;
        const bool is_exported =
            exported.find("\n" + match->str() + "{") != std::string::npos || exported.find("\n" + match->str() + " ") != std::string::npos;
        EXPECT_TRUE(is_exported) << match->str() << " in: " << expression;
      }
      for (std::sregex_iterator match(expression.begin(), expression.end(), label), end; match != end; ++match)
        EXPECT_TRUE(exported.find(match->str()) != std::string::npos) << match->str() << " in: " << expression;
    }
  }
  EXPECT_GT(count, 10U);
}

}  // namespace
}  // namespace hapton
