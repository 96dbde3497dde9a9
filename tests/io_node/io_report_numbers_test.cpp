// Each number in the report, which a person, a dashboard or a script reads, is the one that its name says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "io_node/io_report.h"
#include "runtime/counter_descriptions.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

struct IoReportNumbers : testing::Test {
  LatencyReport report() const { return make_io_report(*stats, {}, "", scheduling); }
  std::unique_ptr<ServoStats> stats = std::make_unique<ServoStats>();
  SchedulingStats scheduling;
};

TEST_F(IoReportNumbers, EachCounterIsUnderItsOwnName) {
  ServoStats& s = *stats;
  GovernorCounters& g = s.governor.counters;
  const std::vector<std::pair<const char*, std::uint64_t*>> counters = {{"samples", &s.samples},
                                                                        {"states_sent", &s.states_sent},
                                                                        {"forces", &s.forces},
                                                                        {"contact_samples", &s.contact_samples},
                                                                        {"forces_in_time", &s.responses.in_time},
                                                                        {"late", &s.responses.late},
                                                                        {"reordered", &s.responses.reordered},
                                                                        {"duplicate", &s.responses.duplicate},
                                                                        {"unknown_echo", &s.responses.unknown},
                                                                        {"superseded", &s.responses.superseded},
                                                                        {"lost", &s.responses.lost},
                                                                        {"no_reply_without_haptics", &s.responses.excused},
                                                                        {"missed_cycles", &s.missed_cycles},
                                                                        {"caught_up_cycles", &s.caught_up_cycles},
                                                                        {"missed_late_wake_up", &s.missed_by_cause[1]},
                                                                        {"missed_device_slow", &s.missed_by_cause[2]},
                                                                        {"missed_work_long", &s.missed_by_cause[3]},
                                                                        {"missed_machine_stalled", &s.missed_by_cause[4]},
                                                                        {"command_timeouts", &g.command_timeouts},
                                                                        {"clamped", &g.clamped},
                                                                        {"rate_limited", &g.rate_limited},
                                                                        {"not_finite", &g.not_finite},
                                                                        {"rejected_old", &g.rejected_old},
                                                                        {"rejected_future", &g.rejected_future},
                                                                        {"workspace_limited", &g.workspace_limited},
                                                                        {"speed_limited", &g.speed_limited},
                                                                        {"energy_damped", &g.damped},
                                                                        {"passivity_limited", &g.kept_passive},
                                                                        {"thermal_limited", &g.thermal_limited},
                                                                        {"dead_mans_switch_releases", &g.releases},
                                                                        {"invalid_poses", &g.bad_samples},
                                                                        {"faults_latched", &g.latched},
                                                                        {"faults_reset", &g.resets},
                                                                        {"resets_rejected", &g.resets_rejected},
                                                                        {"datagrams_sent", &s.hops.link.datagrams_sent},
                                                                        {"bytes_sent", &s.hops.link.bytes_sent},
                                                                        {"bytes_received", &s.hops.link.bytes_received},
                                                                        {"datagrams_received", &s.hub.received},
                                                                        {"sessions_sealed", &s.seal.handshakes},
                                                                        {"rejected_malformed", &s.seal.malformed},
                                                                        {"rejected_wrong_version", &s.seal.wrong_version},
                                                                        {"rejected_wrong_key", &s.seal.wrong_key},
                                                                        {"rejected_replayed_handshakes", &s.seal.replayed_handshakes},
                                                                        {"rejected_too_many_handshakes", &s.seal.too_many_handshakes},
                                                                        {"rejected_oversized", &s.seal.oversized},
                                                                        {"rejected_role", &s.hub.role_violations},
                                                                        {"handshake_retries", &s.seal.retries},
                                                                        {"resets_denied", &s.resets_denied},
                                                                        {"rejected_unknown_session", &s.seal.unknown_session},
                                                                        {"rejected_replayed", &s.seal.replayed},
                                                                        {"rejected_forged", &s.seal.forged},
                                                                        {"rejected_no_slot", &s.seal.no_slot},
                                                                        {"unknown_peers", &s.socket.unknown_peers},
                                                                        {"dropped_by_kernel", &s.socket.dropped},
                                                                        {"floods", &s.socket.floods},
                                                                        {"datagram_budget_exhausted", &s.budget_spent},
                                                                        {"cycles_unreported", &s.cycles_unreported},
                                                                        {"device_releases", &s.cuts},
                                                                        {"joins_rejected", &s.hub.rejections},
                                                                        {"peers_timed_out", &s.hub.timeouts},
                                                                        {"bad_settings", &s.bad_settings},
                                                                        {"markers", &s.markers},
                                                                        {"markers_rejected", &s.markers_rejected},
                                                                        {"moves_rejected", &s.moves_rejected},
                                                                        {"shape_parts_rejected", &s.shape_parts_rejected},
                                                                        {"vision_sent", &s.probe_states_sent},
                                                                        {"vision_unchanged", &s.probe_states_unchanged},
                                                                        {"views_forwarded", &s.views_forwarded},
                                                                        {"drawn", &s.drawn},
                                                                        {"local_forces", &s.local_forces},
                                                                        {"patch_parts", &s.patch_thread.store.parts},
                                                                        {"patches_built", &s.patch_thread.built},
                                                                        {"patches_taken_over", &s.patch_touch.handed_over},
                                                                        {"beyond_patch", &s.patch_touch.beyond},
                                                                        {"beyond_patch_steps", &s.patch_touch.beyond_steps},
                                                                        {"moves_late", &s.patch_touch.late_moves},
                                                                        {"shapes_late", &s.patch_touch.late_shapes},
                                                                        {"echo_sent", &s.echo.sent},
                                                                        {"echo_replied", &s.echo.replied},
                                                                        {"echo_late", &s.echo.late},
                                                                        {"events_dropped", &s.events_dropped}};
  for (std::size_t n = 0; n < counters.size(); ++n) *counters[n].second = 1000 + n;
  s.longest_release_ns = 19'001;
  std::map<std::string, std::int64_t> expected = {{"longest_release_us", 20}};  // rounded up, because it is compared with a limit
  for (std::size_t n = 0; n < counters.size(); ++n) expected[counters[n].first] = 1000 + static_cast<std::int64_t>(n);
  s.hub.undecodable = 1;
  s.hub.other_session = 20;
  s.hub.unknown_peers = 300;
  s.hub.wrong_role = 4000;
  expected["datagrams_rejected"] = 4321;
  EXPECT_EQ(report().counters, expected);
}

TEST_F(IoReportNumbers, EachHopIsUnderItsOwnName) {
  ServoStats& s = *stats;
  const std::vector<std::pair<const char*, LatencyHistogram*>> hops = {{"wake_lateness", &s.wake_lateness},
                                                                       {"device_read", &s.device_read},
                                                                       {"encode", &s.hops.encode},
                                                                       {"wire_out", &s.hops.wire_out},
                                                                       {"haptics_compute", &s.haptics_compute},
                                                                       {"wire_back", &s.hops.wire_back},
                                                                       {"decode", &s.hops.decode},
                                                                       {"device_write", &s.hops.device_write},
                                                                       {"round_trip", &s.round_trip},
                                                                       {"wire", &s.wire},
                                                                       {"force_age", &s.force_age},
                                                                       {"jitter", &s.hops.jitter},
                                                                       {"device_to_drawn", &s.device_to_drawn},
                                                                       {"vision_draw", &s.hops.vision_draw},
                                                                       {"motion_to_photon", &s.hops.motion_to_photon}};
  for (std::size_t n = 0; n < hops.size(); ++n) {
    for (std::size_t i = 0; i <= n; ++i) hops[n].second->record(1000);
  }
  const LatencyReport written = report();
  ASSERT_EQ(written.hops.size(), hops.size());
  for (std::size_t n = 0; n < hops.size(); ++n) {
    EXPECT_EQ(written.hops[n].name, hops[n].first);
    EXPECT_EQ(written.hops[n].histogram.count(), n + 1) << hops[n].first;
  }
}

TEST_F(IoReportNumbers, EachRateAndShareIsUnderItsOwnName) {
  stats->start_ns = 1'000'000'000;
  stats->end_ns = 3'000'000'000;
  stats->rate_hz = 1000.0;
  stats->samples = 1800;
  stats->forces = 1600;
  stats->probe_states_sent = 240;
  stats->drawn = 120;
  stats->frame_rate_hz = 59.0;
  stats->max_force_n = 3.25;
  stats->max_torque_nm = 0.125;
  stats->governor.passivity_given_j = 0.5;
  const std::map<std::string, double> rates = {{"servo_requested", 1000.0}, {"samples", 900.0}, {"forces", 800.0},
                                               {"vision_sent", 120.0},      {"drawn", 60.0},    {"vision_frames", 59.0}};
  EXPECT_EQ(report().rates_hz, rates);
  EXPECT_EQ(report().notes.at("max_force_written_n"), "3.250");
  EXPECT_EQ(report().notes.at("max_torque_written_nm"), "0.1250");
  EXPECT_EQ(report().ratios.at("passivity_given_j"), 0.5);
  EXPECT_FALSE(report().ratios.contains("loop_worked")) << "not measured";
  scheduling = {.is_known = true,
                .worked_share = 0.25,
                .spun_share = 0.125,
                .slept_share = 0.625,
                .waited_ms = 2.5,
                .involuntary_switches = 7,
                .stolen_ms = 0.75,
                .realtime_share = 0.95,
                .near_throttling = 3};
  const LatencyReport written = report();
  EXPECT_EQ(written.ratios.at("loop_worked"), 0.25);
  EXPECT_EQ(written.ratios.at("loop_spun"), 0.125);
  EXPECT_EQ(written.ratios.at("loop_slept"), 0.625);
  EXPECT_EQ(written.ratios.at("realtime_allowed"), 0.95);
  EXPECT_EQ(written.counters.at("loop_involuntary_switches"), 7);
  EXPECT_EQ(written.counters.at("loop_waited_us"), 2500);
  EXPECT_EQ(written.counters.at("machine_stolen_us"), 750);
  EXPECT_EQ(written.counters.at("near_rt_throttling"), 3);
  EXPECT_THAT(describe_run(*stats, scheduling),
              HasSubstr("worked 25.0 %, spun 12.5 %, slept 62.5 %; waited for a CPU 2.5 ms, preempted 7"));
}

TEST_F(IoReportNumbers, EveryCounterIsDescribedAndNoOther) {
  scheduling.is_known = true;
  std::set<std::string> reported, described;
  for (const auto& [name, count] : report().counters) reported.insert(name);
  for (const auto& [name, text] : counter_descriptions()) described.emplace(name);
  EXPECT_EQ(reported, described);
}

TEST_F(IoReportNumbers, ANodeHasItsOwnCounts) {
  PeerStats& vision = stats->peers[2];
  vision.present = true;
  vision.role = NodeRole::vision;
  vision.joined_ns = 4'000'000'000;
  vision.sent = 11;
  vision.send_failures = 22;
  vision.sequence.received = 33;
  vision.sequence.lost = 44;
  vision.sequence.reordered = 55;
  vision.sequence.duplicate = 66;
  stats->end_ns = 5'500'000'000;
  const LatencyReport written = report();
  ASSERT_EQ(written.nodes.size(), 1U);
  const ReportNode& node = written.nodes[0];
  EXPECT_EQ(node.role, "vision");
  EXPECT_EQ(node.seconds, 1.5);
  EXPECT_EQ(node.sent, 11);
  EXPECT_EQ(node.send_failures, 22);
  EXPECT_EQ(node.received, 33);
  EXPECT_EQ(node.lost, 44);
  EXPECT_EQ(node.reordered, 55);
  EXPECT_EQ(node.duplicate, 66);
  stats->end_ns = 3'000'000'000;  // the newest cycle was before the node joined
  EXPECT_EQ(report().nodes[0].seconds, 0.0);
}

TEST_F(IoReportNumbers, TheReportSaysHowTheSceneWasLoaded) {
  stats->setup.scene_hash = 1;
  const auto notes = [&](std::uint32_t loading) {
    stats->setup.scene_loading = loading;
    return report().notes;
  };
  constexpr std::uint32_t kIsKnown = 1, kIsSealed = 2, kIsFitted = 4;  // bits of scene_loading (proto/hapton.proto); the unit is above them
  EXPECT_FALSE(notes(0).contains("scene_unit")) << "an older node does not send it";
  const char* units[] = {"not given", "m", "cm", "mm", "in", "unknown"};
  for (std::uint32_t unit = 0; unit < 6; ++unit) EXPECT_EQ(notes(kIsKnown + (unit << 3U)).at("scene_unit"), units[unit]);
  EXPECT_EQ(notes(kIsKnown + kIsSealed).at("scene_sealed"), "yes");
  EXPECT_EQ(notes(kIsKnown + kIsSealed).at("scene_fitted"), "no");
  EXPECT_EQ(notes(kIsKnown + kIsFitted).at("scene_sealed"), "no");
  EXPECT_EQ(notes(kIsKnown + kIsFitted).at("scene_fitted"), "yes");
}

TEST_F(IoReportNumbers, TheLinesAtTheEndNameEachCause) {
  EXPECT_THAT(describe_run(*stats), Not(HasSubstr("rejected without a reply")));
  stats->responses = {.late = 1, .reordered = 4, .superseded = 3, .lost = 2};
  stats->missed_cycles = 5;
  stats->caught_up_cycles = 9;
  stats->missed_by_cause = {0, 6, 0, 0, 8};
  stats->governor.counters.command_timeouts = 6;
  stats->governor.counters.clamped = 7;
  stats->governor.counters.rate_limited = 8;
  stats->seal = {.malformed = 60,
                 .wrong_version = 20,
                 .wrong_key = 10,
                 .replayed_handshakes = 70,
                 .too_many_handshakes = 80,
                 .unknown_session = 50,
                 .replayed = 40,
                 .forged = 30,
                 .no_slot = 1,     // counts as of an unknown session
                 .oversized = 2};  // counts as malformed
  const std::string text = describe_run(*stats);
  EXPECT_THAT(text,
              HasSubstr("late 1, lost 2, superseded 3, reordered 4, missed cycles 5, command timeouts 6, clamped 7, rate-limited 8\n"));
  EXPECT_THAT(
      text,
      HasSubstr("rejected without a reply: 10 with another key, 20 of another version, 30 forged, 40 replayed, 51 of an unknown session, "
                "62 malformed, 70 replayed handshakes, 80 handshakes above the rate limit\n"));
  EXPECT_THAT(text, HasSubstr("cycles missed: 5 skipped, 9 caught up; causes: 6 late wake-up, 8 machine stalled\n"));
}

TEST_F(IoReportNumbers, TheDevicesStateIsNamed) {
  for (const auto& [status, name] : {std::pair{DeviceStatus::ready, "ready"},
                                     {DeviceStatus::ended, "ended"},
                                     {DeviceStatus::fault, "fault"},
                                     {DeviceStatus::away, "away"},
                                     {DeviceStatus::calibrating, "calibrating"}}) {
    stats->device_status = status;
    EXPECT_EQ(report().notes.at("device_state"), name);
  }
  for (const auto& [status, part] : {std::pair{ProbeStatus::ok, "ok"},
                                     {ProbeStatus::no_haptics, "no haptics node"},
                                     {ProbeStatus::fault_latched, "fault is latched"},
                                     {ProbeStatus::device_away, "device is away"},
                                     {ProbeStatus::calibrating, "being calibrated"},
                                     {ProbeStatus::out_of_reach, "out of the device's reach"},
                                     {ProbeStatus::too_small, "far too small"},
                                     {ProbeStatus::hand_inside, "inside a body"}}) {
    stats->status = status;
    EXPECT_THAT(report().notes.at("status_now"), HasSubstr(part));
  }
  stats->status = ProbeStatus::no_haptics;
  stats->newest_round_trip_s = 0.019;
  EXPECT_EQ(report().notes.at("status_now"), "no force: no haptics node replies");
  stats->newest_round_trip_s = 0.0412;
  EXPECT_EQ(report().notes.at("status_now"),
            "no force: replies of haptics_node take 41 ms, and a force lasts 20 ms; shorten the network path, or see docs/remote.md");
  stats->status = ProbeStatus::fault_latched;
  EXPECT_EQ(report().notes.at("status_now"), "no force: a fault is latched") << "the fault has to be fixed first";
  stats->status = ProbeStatus::ok;
  EXPECT_EQ(report().notes.at("status_now"), "ok") << "the force is computed here";
  stats->touched_object = 0;
  EXPECT_EQ(report().notes.at("touched_object"), "0");
  stats->touched_object = -1;
  EXPECT_EQ(report().notes.at("touched_object"), "none");
}

}  // namespace
}  // namespace hapton
