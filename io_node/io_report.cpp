#include "io_node/io_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "link/udp_endpoint.h"
#include "runtime/hop_table.h"

namespace hapton {
namespace {

std::int64_t whole(std::uint64_t count) { return static_cast<std::int64_t>(count); }

double per_second(std::uint64_t count, const ServoStats& stats) {
  return stats.seconds() > 0.0 ? static_cast<double>(count) / stats.seconds() : 0.0;
}

std::uint64_t missed_by(const ServoStats& stats, MissCause cause) { return stats.missed_by_cause[static_cast<std::size_t>(cause)]; }

// "3 late wake-up, 1 machine stalled"
std::string describe_causes(const ServoStats& stats) {
  std::string text;
  for (std::size_t cause = 1; cause < stats.missed_by_cause.size(); ++cause) {
    if (stats.missed_by_cause[cause] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", stats.missed_by_cause[cause], to_string(static_cast<MissCause>(cause)));
  }
  return text;
}

void add_counters(LatencyReport& report, const ServoStats& s) {
  const auto rejected = s.hub.undecodable + s.hub.other_session + s.hub.strangers + s.hub.misplaced;
  report.counters = {{"samples", whole(s.samples)},
                     {"states_sent", whole(s.states_sent)},
                     {"forces", whole(s.forces)},
                     {"contact_samples", whole(s.contact_samples)},
                     {"forces_in_time", whole(s.ledger.in_time)},
                     {"late", whole(s.ledger.late)},
                     {"reordered", whole(s.ledger.reordered)},
                     {"duplicate", whole(s.ledger.duplicate)},
                     {"unknown_echo", whole(s.ledger.unknown)},
                     {"superseded", whole(s.ledger.superseded)},
                     {"lost", whole(s.ledger.lost)},
                     {"unanswered_without_haptics", whole(s.ledger.excused)},
                     {"missed_cycles", whole(s.missed_cycles)},
                     {"caught_up_cycles", whole(s.caught_up_cycles)},
                     {"missed_late_wake_up", whole(missed_by(s, MissCause::late_wake_up))},
                     {"missed_device_slow", whole(missed_by(s, MissCause::device_slow))},
                     {"missed_work_long", whole(missed_by(s, MissCause::work_long))},
                     {"missed_machine_stalled", whole(missed_by(s, MissCause::machine_stalled))},
                     {"silence_events", whole(s.governor.counters.silences)},
                     {"clamped", whole(s.governor.counters.clamped)},
                     {"slewed", whole(s.governor.counters.slewed)},
                     {"not_finite", whole(s.governor.counters.not_finite)},
                     {"refused_old", whole(s.governor.counters.refused_old)},
                     {"refused_future", whole(s.governor.counters.refused_future)},
                     {"longest_release_us", (s.longest_release_ns + 999) / 1000},
                     {"datagrams_sent", whole(s.ways.link.datagrams_sent)},
                     {"bytes_sent", whole(s.ways.link.bytes_sent)},
                     {"bytes_received", whole(s.ways.link.bytes_received)},
                     {"datagrams_received", whole(s.hub.received)},
                     {"datagrams_rejected", whole(rejected)},
                     {"sessions_sealed", whole(s.seal.handshakes)},
                     {"refused_malformed", whole(s.seal.malformed)},
                     {"refused_wrong_version", whole(s.seal.wrong_version)},
                     {"refused_wrong_key", whole(s.seal.wrong_key)},
                     {"refused_replayed_handshakes", whole(s.seal.replayed_handshakes)},
                     {"refused_too_many_handshakes", whole(s.seal.too_many_handshakes)},
                     {"refused_oversized", whole(s.seal.oversized)},
                     {"refused_role", whole(s.hub.role_violations)},
                     {"handshake_retries", whole(s.seal.retries)},
                     {"resets_denied", whole(s.resets_denied)},
                     {"refused_unknown_session", whole(s.seal.unknown_session)},
                     {"refused_replayed", whole(s.seal.replayed)},
                     {"refused_forged", whole(s.seal.forged)},
                     {"refused_no_place", whole(s.seal.no_place)},
                     {"strangers", whole(s.socket.strangers)},
                     {"dropped_by_kernel", whole(s.socket.dropped)},
                     {"floods", whole(s.socket.floods)},
                     {"budget_spent", whole(s.budget_spent)},
                     {"cycles_untold", whole(s.cycles_untold)},
                     {"device_cuts", whole(s.cuts)},
                     {"joins_refused", whole(s.hub.refusals)},
                     {"peers_timed_out", whole(s.hub.timeouts)},
                     {"bad_settings", whole(s.bad_settings)},
                     {"vision_sent", whole(s.probe_states_sent)},
                     {"vision_spared", whole(s.probe_states_spared)},
                     {"views_forwarded", whole(s.views_forwarded)},
                     {"drawn", whole(s.drawn)},
                     {"echo_sent", whole(s.echo.sent)},
                     {"echo_answered", whole(s.echo.answered)},
                     {"echo_late", whole(s.echo.late)},
                     {"events_dropped", whole(s.events_dropped)}};
}

// What the safety governor does and has done.
void add_safety(LatencyReport& report, const GovernorFigures& g) {
  const GovernorCounters& c = g.counters;
  report.counters["workspace_stopped"] = whole(c.stopped);
  report.counters["speed_braked"] = whole(c.braked);
  report.counters["energy_damped"] = whole(c.damped);
  report.counters["thermal_cooled"] = whole(c.cooled);
  report.counters["let_go_of"] = whole(c.releases);
  report.counters["bad_device_samples"] = whole(c.bad_samples);
  report.counters["faults_latched"] = whole(c.latched);
  report.counters["faults_reset"] = whole(c.resets);
  report.counters["resets_refused"] = whole(c.resets_refused);
  report.ratios["fault_latched_now"] = g.fault == SafetyFault::none ? 0.0 : 1.0;
  report.ratios["thermal_load"] = g.thermal_load;
  report.ratios["energy_spent"] = g.energy_most_j > 0.0 ? g.energy_spent_j / g.energy_most_j : 0.0;
  report.notes["governor"] = std::string(to_string(g.state));
  report.notes["safety_fault"] = std::string(to_string(g.fault));
  if (g.fault != SafetyFault::none) report.notes["safety_fault_is"] = std::string(describe(g.fault));
}

std::vector<ReportNode> make_nodes(const ServoStats& stats) {
  std::vector<ReportNode> nodes;
  for (const PeerFigures& peer : stats.peers) {
    if (!peer.present) continue;
    nodes.push_back({.role = name_of(peer.role),
                     .address = to_string(peer.address),
                     .seconds = std::max(0.0, 1e-9 * static_cast<double>(stats.end_ns - peer.joined_ns)),
                     .received = whole(peer.heard.received),
                     .lost = whole(peer.heard.lost),
                     .reordered = whole(peer.heard.reordered),
                     .duplicate = whole(peer.heard.duplicate),
                     .sent = whole(peer.sent),
                     .send_failures = whole(peer.send_failures)});
  }
  return nodes;
}

std::string describe_clocks(const WayStats& ways) {
  if (!ways.is_offset_known) return "not known yet";
  const std::string measured = fmt::format("{:.1f} us, within {:.1f} us", 1e-3 * static_cast<double>(ways.clock_offset_ns),
                                           1e-3 * static_cast<double>(ways.clock_error_ns));
  return ways.is_one_clock ? "one clock; measured it would be " + measured : measured;
}

void add_scheduling(LatencyReport& report, const SchedulingFigures& s) {
  if (!s.is_known) return;
  report.ratios["loop_worked"] = s.worked_share;
  report.ratios["loop_spun"] = s.spun_share;
  report.ratios["loop_slept"] = s.slept_share;
  report.ratios["realtime_allowed"] = s.realtime_share;
  report.counters["loop_involuntary_switches"] = whole(s.involuntary_switches);
  report.counters["loop_waited_us"] = std::llround(1e3 * s.waited_ms);
  report.counters["machine_stolen_us"] = std::llround(1e3 * s.stolen_ms);
  report.counters["near_throttling"] = whole(s.near_throttling);
}

std::string describe_scheduling(const SchedulingFigures& s) {
  return fmt::format(
      "loop: worked {:.1f} %, spun {:.1f} %, slept {:.1f} %; kept waiting for a CPU {:.1f} ms, displaced {} times, {:.0f} ms stolen from "
      "the machine\n",
      100.0 * s.worked_share, 100.0 * s.spun_share, 100.0 * s.slept_share, s.waited_ms, s.involuntary_switches, s.stolen_ms);
}

const char* name_of(DeviceStatus status) {
  switch (status) {
    case DeviceStatus::ready:
      return "ready";
    case DeviceStatus::ended:
      return "ended";
    case DeviceStatus::fault:
      return "fault";
    case DeviceStatus::away:
      return "away";
    case DeviceStatus::calibrating:
      return "calibrating";
  }
  return "ready";
}

// What the hardware says of itself, as far as it says anything.
void add_device(LatencyReport& report, const ServoStats& stats) {
  const auto add = [&](const char* name, std::string_view text) {
    if (!text.empty()) report.notes[name] = std::string(text);
  };
  report.notes["device_state"] = name_of(stats.device_status);
  report.notes["device_calibrated"] = stats.device.is_calibrated ? "yes" : "no";
  add("device_model", stats.device.model);
  add("device_serial", stats.device.serial);
  add("device_firmware", stats.device.firmware);
  if (stats.device.motor_temperature >= 0.0) report.notes["motor_temperature"] = fmt::format("{:.3f}", stats.device.motor_temperature);
}

std::string text_of(const HapticsSetup::Text& text) {
  return {text.data(), static_cast<std::size_t>(std::find(text.begin(), text.end(), '\0') - text.begin())};
}

// What was touched and with what, as the haptics node told last.
void add_setup(LatencyReport& report, const HapticsSetup& setup) {
  if (setup.scene_hash == 0) return;
  constexpr std::array kUnits = {"not given", "m", "cm", "mm", "in"};
  report.notes["scene"] = text_of(setup.scene);
  report.notes["scene_hash"] = fmt::format("{:016x}", setup.scene_hash);
  report.notes["method"] = text_of(setup.method);
  report.notes["haptics_build"] = text_of(setup.build);
  if (setup.scene_loading == 0) return;
  const std::uint32_t unit = setup.scene_loading >> 3;  // proto/hapton.proto says what each bit means
  report.notes["scene_unit"] = unit < kUnits.size() ? kUnits[unit] : "unknown";
  report.notes["scene_sealed"] = (setup.scene_loading & 2U) != 0 ? "yes" : "no";
  report.notes["scene_fitted"] = (setup.scene_loading & 4U) != 0 ? "yes" : "no";
}

const char* describe_status(ProbeStatus status) {
  switch (status) {
    case ProbeStatus::ok:
      break;
    case ProbeStatus::no_haptics:
      return "no force: no haptics node answers";
    case ProbeStatus::fault_latched:
      return "no force: a fault is latched";
    case ProbeStatus::device_away:
      return "no force: the device is away";
    case ProbeStatus::calibrating:
      return "no force: the device is being calibrated";
    case ProbeStatus::out_of_reach:
      return "the scene is out of the device's reach";
    case ProbeStatus::too_small:
      return "the scene is a speck in the device's workspace";
  }
  return "ok";
}

void add_ratio(LatencyReport& report, const ServoStats& stats, const char* name, double fraction) {
  const double echo_ns = stats.bare_echo.quantile_ns(fraction);
  if (stats.round_trip.count() > 0 && echo_ns > 0.0) report.ratios[name] = stats.round_trip.quantile_ns(fraction) / echo_ns;
}

// The way of one sample first, in its order; then what it adds up to.
std::vector<LatencyHop> make_hops(const ServoStats& stats, bool has_echo) {
  std::vector<LatencyHop> hops = {{"wake_lateness", stats.wake_lateness},
                                  {"device_read", stats.device_read},
                                  {"encode", stats.ways.encode},
                                  {"wire_out", stats.ways.wire_out},
                                  {"haptics_compute", stats.haptics_compute},
                                  {"wire_back", stats.ways.wire_back},
                                  {"decode", stats.ways.decode},
                                  {"device_write", stats.ways.device_write},
                                  {"round_trip", stats.round_trip},
                                  {"wire", stats.wire},
                                  {"force_age", stats.force_age},
                                  {"jitter", stats.ways.jitter},
                                  {"device_to_drawn", stats.device_to_drawn},
                                  {"vision_draw", stats.ways.vision_draw},
                                  {"motion_to_photon", stats.ways.motion_to_photon}};
  if (has_echo) hops.push_back({"bare_echo", stats.bare_echo});
  return hops;
}

std::string describe_hops(const ServoStats& stats) {
  std::vector<HopRow> rows;
  for (const LatencyHop& hop : make_hops(stats, true)) rows.push_back(make_hop_row(hop));
  return make_hop_table(rows);
}

}  // namespace

const char* name_of(NodeRole role) {
  switch (role) {
    case NodeRole::haptics:
      return "haptics";
    case NodeRole::vision:
      return "vision";
    case NodeRole::tool:
      return "tool";
    case NodeRole::io:
      break;
  }
  return "io";
}

LatencyReport make_io_report(const ServoStats& stats, const IoOptions& options, const std::string& realtime,
                             const SchedulingFigures& scheduling) {
  LatencyReport report;
  report.program = "io_node";
  report.machine = read_machine_info();
  report.seconds = stats.seconds();
  report.rates_hz = {{"servo_asked", stats.rate_hz},
                     {"samples", per_second(stats.samples, stats)},
                     {"forces", per_second(stats.forces, stats)},
                     {"vision_sent", per_second(stats.probe_states_sent, stats)},
                     {"drawn", per_second(stats.drawn, stats)},
                     {"vision_frames", stats.frame_rate_hz}};
  add_counters(report, stats);
  add_scheduling(report, scheduling);
  add_ratio(report, stats, "round_trip_over_echo_p50", 0.5);
  add_ratio(report, stats, "round_trip_over_echo_p99", 0.99);
  report.notes = {{"bind", options.bind},
                  {"device", options.device.name},
                  {"realtime", realtime},
                  {"seed", std::to_string(options.device.seed)},
                  {"max_force_written_n", fmt::format("{:.3f}", stats.max_force_n)}};
  report.notes["haptics_clock_ahead"] = describe_clocks(stats.ways);
  if (stats.ways.is_offset_known) {
    report.notes["haptics_clock_ahead_ns"] = std::to_string(stats.ways.clock_offset_ns);
    report.notes["haptics_clock_error_ns"] = std::to_string(stats.ways.clock_error_ns);
  }
  add_setup(report, stats.setup);
  report.notes["status_now"] = describe_status(stats.status);
  if (stats.reach == SceneReach::out_of_reach) report.notes["reach"] = describe_status(ProbeStatus::out_of_reach);
  if (stats.reach == SceneReach::too_small) report.notes["reach"] = describe_status(ProbeStatus::too_small);
  report.nodes = make_nodes(stats);
  add_device(report, stats);
  add_safety(report, stats.governor);
  if (!options.name.empty()) report.notes["name"] = options.name;
  if (!options.device.id.empty()) report.notes["device_id"] = options.device.id;
  if (!options.device.file.empty()) report.notes["device_file"] = options.device.file;
  if (!options.device.trajectory.empty()) report.notes["trajectory"] = options.device.trajectory;
  if (!options.echo_probe.empty()) report.notes["echo_probe"] = options.echo_probe;
  if (options.echo_bytes > 0) report.notes["echo_bytes"] = std::to_string(options.echo_bytes);
  report.hops = make_hops(stats, !options.echo_probe.empty());
  return report;
}

std::string describe_run(const ServoStats& s, const SchedulingFigures& scheduling) {
  std::string text = fmt::format("{:.1f} s, {} samples ({:.0f} Hz), {} forces, {} in contact, strongest {:.2f} N\n", s.seconds(), s.samples,
                                 per_second(s.samples, s), s.forces, s.contact_samples, s.max_force_n);
  text += fmt::format("late {}, lost {}, superseded {}, reordered {}, missed cycles {}, silences {}, clamped {}, slewed {}\n",
                      s.ledger.late, s.ledger.lost, s.ledger.superseded, s.ledger.reordered, s.missed_cycles, s.governor.counters.silences,
                      s.governor.counters.clamped, s.governor.counters.slewed);
  if (const GovernorFigures& g = s.governor; g.counters.latched > 0) {
    text += fmt::format("faults: {} latched, {} reset, {} resets refused; now: {}\n", g.counters.latched, g.counters.resets,
                        g.counters.resets_refused, describe(g.fault));
  }
  if (s.seal.refused() > 0) {
    text += fmt::format(
        "refused in silence: {} with another key, {} of another version, {} forged, {} replayed, {} of no session, {} of no known form, {} "
        "replayed handshakes, {} handshakes too many\n",
        s.seal.wrong_key, s.seal.wrong_version, s.seal.forged, s.seal.replayed, s.seal.unknown_session + s.seal.no_place,
        s.seal.malformed + s.seal.oversized, s.seal.replayed_handshakes, s.seal.too_many_handshakes);
  }
  if (s.missed_cycles + s.caught_up_cycles > 0) {
    text += fmt::format("cycles missed: {} skipped, {} caught up; causes: {}\n", s.missed_cycles, s.caught_up_cycles, describe_causes(s));
  }
  if (scheduling.is_known) text += describe_scheduling(scheduling);
  text += describe_hops(s);
  if (s.bare_echo.count() > 0 && s.round_trip.count() > 0) {
    text += fmt::format("the round trip is {:.2f} times as long as the bare echo at p50, {:.2f} times at p99\n",
                        s.round_trip.quantile_ns(0.5) / s.bare_echo.quantile_ns(0.5),
                        s.round_trip.quantile_ns(0.99) / s.bare_echo.quantile_ns(0.99));
  }
  return text;
}

}  // namespace hapton
