#include "io_node/io_report.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "link/udp_endpoint.h"
#include "link/wire_text.h"
#include "runtime/hop_table.h"

namespace hapton {
namespace {

std::int64_t to_int64(std::uint64_t count) { return static_cast<std::int64_t>(count); }

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

using Counters = std::map<std::string, std::int64_t>;

// The counters of samples, forces and cycles.
Counters count_forces(const ServoStats& stats) {
  return {{"samples", to_int64(stats.samples)},
          {"states_sent", to_int64(stats.states_sent)},
          {"forces", to_int64(stats.forces)},
          {"contact_samples", to_int64(stats.contact_samples)},
          {"forces_in_time", to_int64(stats.responses.in_time)},
          {"late", to_int64(stats.responses.late)},
          {"reordered", to_int64(stats.responses.reordered)},
          {"duplicate", to_int64(stats.responses.duplicate)},
          {"unknown_echo", to_int64(stats.responses.unknown)},
          {"superseded", to_int64(stats.responses.superseded)},
          {"lost", to_int64(stats.responses.lost)},
          {"no_reply_without_haptics", to_int64(stats.responses.excused)},
          {"missed_cycles", to_int64(stats.missed_cycles)},
          {"caught_up_cycles", to_int64(stats.caught_up_cycles)},
          {"cycles_unreported", to_int64(stats.cycles_unreported)},
          {"device_releases", to_int64(stats.cuts)},
          {"missed_late_wake_up", to_int64(missed_by(stats, MissCause::late_wake_up))},
          {"missed_device_slow", to_int64(missed_by(stats, MissCause::device_slow))},
          {"missed_work_long", to_int64(missed_by(stats, MissCause::work_long))},
          {"missed_machine_stalled", to_int64(missed_by(stats, MissCause::machine_stalled))},
          {"command_timeouts", to_int64(stats.governor.counters.command_timeouts)},
          {"clamped", to_int64(stats.governor.counters.clamped)},
          {"rate_limited", to_int64(stats.governor.counters.rate_limited)},
          {"not_finite", to_int64(stats.governor.counters.not_finite)},
          {"rejected_old", to_int64(stats.governor.counters.rejected_old)},
          {"rejected_future", to_int64(stats.governor.counters.rejected_future)},
          {"longest_release_us", (stats.longest_release_ns + 999) / 1000}};
}

Counters count_datagrams(const ServoStats& stats) {
  const auto rejected = stats.hub.undecodable + stats.hub.other_session + stats.hub.unknown_peers + stats.hub.wrong_role;
  return {{"datagrams_sent", to_int64(stats.hops.link.datagrams_sent)},
          {"bytes_sent", to_int64(stats.hops.link.bytes_sent)},
          {"bytes_received", to_int64(stats.hops.link.bytes_received)},
          {"datagrams_received", to_int64(stats.hub.received)},
          {"datagrams_rejected", to_int64(rejected)},
          {"sessions_sealed", to_int64(stats.seal.handshakes)},
          {"rejected_malformed", to_int64(stats.seal.malformed)},
          {"rejected_wrong_version", to_int64(stats.seal.wrong_version)},
          {"rejected_wrong_key", to_int64(stats.seal.wrong_key)},
          {"rejected_replayed_handshakes", to_int64(stats.seal.replayed_handshakes)},
          {"rejected_too_many_handshakes", to_int64(stats.seal.too_many_handshakes)},
          {"rejected_oversized", to_int64(stats.seal.oversized)},
          {"rejected_role", to_int64(stats.hub.role_violations)},
          {"handshake_retries", to_int64(stats.seal.retries)},
          {"resets_denied", to_int64(stats.resets_denied)},
          {"rejected_unknown_session", to_int64(stats.seal.unknown_session)},
          {"rejected_replayed", to_int64(stats.seal.replayed)},
          {"rejected_forged", to_int64(stats.seal.forged)},
          {"rejected_no_slot", to_int64(stats.seal.no_slot)},
          {"unknown_peers", to_int64(stats.socket.unknown_peers)},
          {"dropped_by_kernel", to_int64(stats.socket.dropped)},
          {"floods", to_int64(stats.socket.floods)},
          {"datagram_budget_exhausted", to_int64(stats.budget_spent)},
          {"joins_rejected", to_int64(stats.hub.rejections)},
          {"peers_timed_out", to_int64(stats.hub.timeouts)}};
}

// The counters of what nodes request and of what vision nodes show.
Counters count_requests(const ServoStats& stats) {
  return {{"bad_settings", to_int64(stats.bad_settings)},
          {"markers", to_int64(stats.markers)},
          {"markers_rejected", to_int64(stats.markers_rejected)},
          {"moves_rejected", to_int64(stats.moves_rejected)},
          {"shape_parts_rejected", to_int64(stats.shape_parts_rejected)},
          {"vision_sent", to_int64(stats.probe_states_sent)},
          {"vision_unchanged", to_int64(stats.probe_states_unchanged)},
          {"views_forwarded", to_int64(stats.views_forwarded)},
          {"drawn", to_int64(stats.drawn)}};
}

// The counters of forces from patches and of the bare echo.
Counters count_patches(const ServoStats& stats) {
  return {{"local_forces", to_int64(stats.local_forces)},
          {"patch_parts", to_int64(stats.patch_thread.store.parts)},
          {"patches_built", to_int64(stats.patch_thread.built)},
          {"patches_taken_over", to_int64(stats.patch_touch.handed_over)},
          {"beyond_patch", to_int64(stats.patch_touch.beyond)},
          {"beyond_patch_steps", to_int64(stats.patch_touch.beyond_steps)},
          {"moves_late", to_int64(stats.patch_touch.late_moves)},
          {"shapes_late", to_int64(stats.patch_touch.late_shapes)},
          {"echo_sent", to_int64(stats.echo.sent)},
          {"echo_replied", to_int64(stats.echo.replied)},
          {"echo_late", to_int64(stats.echo.late)},
          {"events_dropped", to_int64(stats.events_dropped)}};
}

void add_counters(LatencyReport& report, const ServoStats& stats) {
  for (Counters counters : {count_forces(stats), count_datagrams(stats), count_requests(stats), count_patches(stats)})
    report.counters.merge(counters);
}

// The state and counters of the safety governor.
void add_safety(LatencyReport& report, const GovernorStats& g) {
  const GovernorCounters& c = g.counters;
  report.counters["workspace_limited"] = to_int64(c.workspace_limited);
  report.counters["speed_limited"] = to_int64(c.speed_limited);
  report.counters["energy_damped"] = to_int64(c.damped);
  report.counters["passivity_limited"] = to_int64(c.kept_passive);
  report.counters["thermal_limited"] = to_int64(c.thermal_limited);
  report.counters["dead_mans_switch_releases"] = to_int64(c.releases);
  report.counters["invalid_poses"] = to_int64(c.bad_samples);
  report.counters["faults_latched"] = to_int64(c.latched);
  report.counters["faults_reset"] = to_int64(c.resets);
  report.counters["resets_rejected"] = to_int64(c.resets_rejected);
  report.ratios["fault_latched_now"] = g.fault == SafetyFault::none ? 0.0 : 1.0;
  report.ratios["thermal_load"] = g.thermal_load;
  report.ratios["passivity_given_j"] = g.passivity_given_j;
  report.ratios["energy_spent"] = g.energy_share();
  report.notes["governor"] = std::string(to_string(g.state));
  report.notes["safety_fault"] = std::string(to_string(g.fault));
  if (g.fault != SafetyFault::none) report.notes["safety_fault_text"] = std::string(describe(g.fault));
}

std::vector<ReportNode> make_nodes(const ServoStats& stats) {
  std::vector<ReportNode> nodes;
  for (const PeerStats& peer : stats.peers) {
    if (!peer.present) continue;
    nodes.push_back({.role = name_of(peer.role),
                     .address = to_string(peer.address),
                     .seconds = std::max(0.0, 1e-9 * static_cast<double>(stats.end_ns - peer.joined_ns)),
                     .received = to_int64(peer.sequence.received),
                     .lost = to_int64(peer.sequence.lost),
                     .reordered = to_int64(peer.sequence.reordered),
                     .duplicate = to_int64(peer.sequence.duplicate),
                     .sent = to_int64(peer.sent),
                     .send_failures = to_int64(peer.send_failures)});
  }
  return nodes;
}

std::string describe_clocks(const HopStats& hops) {
  if (!hops.is_offset_known) return "not measured yet";
  const std::string measured = fmt::format("{:.1f} us, within {:.1f} us", 1e-3 * static_cast<double>(hops.clock_offset_ns),
                                           1e-3 * static_cast<double>(hops.clock_error_ns));
  return hops.is_one_clock ? "same clock; measured difference " + measured : measured;
}

void add_scheduling(LatencyReport& report, const SchedulingStats& stats) {
  if (!stats.is_known) return;
  report.ratios["loop_worked"] = stats.worked_share;
  report.ratios["loop_spun"] = stats.spun_share;
  report.ratios["loop_slept"] = stats.slept_share;
  report.ratios["realtime_allowed"] = stats.realtime_share;
  report.counters["loop_involuntary_switches"] = to_int64(stats.involuntary_switches);
  report.counters["loop_waited_us"] = std::llround(1e3 * stats.waited_ms);
  report.counters["machine_stolen_us"] = std::llround(1e3 * stats.stolen_ms);
  report.counters["near_rt_throttling"] = to_int64(stats.near_throttling);
}

std::string describe_scheduling(const SchedulingStats& stats) {
  return fmt::format(
      "loop: worked {:.1f} %, spun {:.1f} %, slept {:.1f} %; waited for a CPU {:.1f} ms, preempted {} times, {:.0f} ms steal time "
      "(hypervisor)\n",
      100.0 * stats.worked_share, 100.0 * stats.spun_share, 100.0 * stats.slept_share, stats.waited_ms, stats.involuntary_switches,
      stats.stolen_ms);
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

// The hardware's own condition, if it reports any.
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

// The scene and method, as last reported by the haptics node.
void add_setup(LatencyReport& report, const HapticsSetup& setup, std::uint64_t given_hash) {
  const bool is_reported = setup.scene_hash != 0 || setup.method[0] != '\0';
  if (!is_reported) return;
  constexpr std::array kUnits = {"not given", "m", "cm", "mm", "in"};
  report.notes["scene"] = text_of(setup.scene);
  if (setup.scene_hash != 0) report.notes["scene_hash"] = fmt::format("{:016x}", setup.scene_hash);
  if (given_hash != 0) report.notes["scene_shape_hash"] = fmt::format("{:016x}", given_hash);
  report.notes["method"] = text_of(setup.method);
  report.notes["haptics_build"] = text_of(setup.build);
  if (setup.scene_loading == 0) return;
  const std::uint32_t unit = setup.scene_loading >> 3;  // proto/hapton.proto says what each bit means
  report.notes["scene_unit"] = unit < kUnits.size() ? kUnits[unit] : "unknown";
  report.notes["scene_sealed"] = (setup.scene_loading & 2U) != 0 ? "yes" : "no";
  report.notes["scene_fitted"] = (setup.scene_loading & 4U) != 0 ? "yes" : "no";
}

std::string describe_status(ProbeStatus status) {
  switch (status) {
    case ProbeStatus::ok:
      break;
    case ProbeStatus::no_haptics:
      return "no force: no haptics node replies";
    case ProbeStatus::fault_latched:
      return "no force: a fault is latched";
    case ProbeStatus::device_away:
      return "no force: the device is away";
    case ProbeStatus::calibrating:
      return "no force: the device is being calibrated";
    case ProbeStatus::out_of_reach:
      return "the scene is out of the device's reach";
    case ProbeStatus::too_small:
      return "the scene is far too small for the device's workspace";
    case ProbeStatus::hand_inside:
      return "the stylus has been inside a body since haptics_node started: that body gives no force, or holds the stylus inside";
  }
  return "ok";
}

// Replies that are too late have another remedy than a missing haptics node.
std::string describe_status(const ServoStats& stats) {
  if (stats.status != ProbeStatus::no_haptics || !stats.are_replies_late()) return describe_status(stats.status);
  return fmt::format(
      "no force: replies of haptics_node take {:.0f} ms, and a force lasts {} ms; shorten the network path, or see docs/remote.md",
      1e3 * stats.newest_round_trip_s, kCommandTimeoutNs / 1'000'000);
}

void add_ratio(LatencyReport& report, const ServoStats& stats, const char* name, double fraction) {
  const double echo_ns = stats.bare_echo.quantile_ns(fraction);
  if (stats.round_trip.count() > 0 && echo_ns > 0.0) report.ratios[name] = stats.round_trip.quantile_ns(fraction) / echo_ns;
}

// The hops of one sample first, in order; then their total.
std::vector<LatencyHop> make_hops(const ServoStats& stats, bool has_echo) {
  std::vector<LatencyHop> hops = {{"wake_lateness", stats.wake_lateness},
                                  {"device_read", stats.device_read},
                                  {"encode", stats.hops.encode},
                                  {"wire_out", stats.hops.wire_out},
                                  {"haptics_compute", stats.haptics_compute},
                                  {"wire_back", stats.hops.wire_back},
                                  {"decode", stats.hops.decode},
                                  {"device_write", stats.hops.device_write},
                                  {"round_trip", stats.round_trip},
                                  {"wire", stats.wire},
                                  {"force_age", stats.force_age},
                                  {"jitter", stats.hops.jitter},
                                  {"device_to_drawn", stats.device_to_drawn},
                                  {"vision_draw", stats.hops.vision_draw},
                                  {"motion_to_photon", stats.hops.motion_to_photon}};
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
                             const SchedulingStats& scheduling) {
  LatencyReport report;
  report.program = "io_node";
  report.machine = read_machine_info();
  report.seconds = stats.seconds();
  report.rates_hz = {{"servo_requested", stats.rate_hz},          {"samples", per_second(stats.samples, stats)},
                     {"forces", per_second(stats.forces, stats)}, {"vision_sent", per_second(stats.probe_states_sent, stats)},
                     {"drawn", per_second(stats.drawn, stats)},   {"vision_frames", stats.frame_rate_hz}};
  add_counters(report, stats);
  add_scheduling(report, scheduling);
  add_ratio(report, stats, "round_trip_over_echo_p50", 0.5);
  add_ratio(report, stats, "round_trip_over_echo_p99", 0.99);
  report.notes = {{"bind", options.bind},
                  {"device", options.device.name},
                  {"realtime", realtime},
                  {"seed", std::to_string(options.device.seed)},
                  {"max_force_written_n", fmt::format("{:.3f}", stats.max_force_n)},
                  {"max_torque_written_nm", fmt::format("{:.4f}", stats.max_torque_nm)}};
  report.notes["haptics_clock_offset"] = describe_clocks(stats.hops);
  if (stats.hops.is_offset_known) {
    report.notes["haptics_clock_offset_ns"] = std::to_string(stats.hops.clock_offset_ns);
    report.notes["haptics_clock_error_ns"] = std::to_string(stats.hops.clock_error_ns);
  }
  add_setup(report, stats.setup, stats.scene_given_hash);
  report.notes["status_now"] = describe_status(stats);
  report.notes["touched_object"] = stats.touched_object < 0 ? "none" : std::to_string(stats.touched_object);
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

std::string describe_run(const ServoStats& stats, const SchedulingStats& scheduling) {
  std::string text = fmt::format("{:.1f} s, {} samples ({:.0f} Hz), {} forces, {} in contact, maximum {:.2f} N{}\n", stats.seconds(),
                                 stats.samples, per_second(stats.samples, stats), stats.forces, stats.contact_samples, stats.max_force_n,
                                 stats.max_torque_nm > 0.0 ? fmt::format(", {:.4f} Nm", stats.max_torque_nm) : std::string());
  // Of the numbers in the line above, only the maximum includes these forces.
  if (stats.local_forces > 0)
    text += fmt::format("and {} forces computed here, from parts of the scene (docs/remote.md)\n", stats.local_forces);
  text +=
      fmt::format("late {}, lost {}, superseded {}, reordered {}, missed cycles {}, command timeouts {}, clamped {}, rate-limited {}\n",
                  stats.responses.late, stats.responses.lost, stats.responses.superseded, stats.responses.reordered, stats.missed_cycles,
                  stats.governor.counters.command_timeouts, stats.governor.counters.clamped, stats.governor.counters.rate_limited);
  if (const GovernorStats& g = stats.governor; g.counters.latched > 0) {
    text += fmt::format("faults: {} latched, {} reset, {} resets rejected; now: {}\n", g.counters.latched, g.counters.resets,
                        g.counters.resets_rejected, describe(g.fault));
  }
  if (stats.seal.rejected() > 0) {
    text += fmt::format(
        "rejected without a reply: {} with another key, {} of another version, {} forged, {} replayed, {} of an unknown session, "
        "{} malformed, {} replayed handshakes, {} handshakes above the rate limit\n",
        stats.seal.wrong_key, stats.seal.wrong_version, stats.seal.forged, stats.seal.replayed,
        stats.seal.unknown_session + stats.seal.no_slot, stats.seal.malformed + stats.seal.oversized, stats.seal.replayed_handshakes,
        stats.seal.too_many_handshakes);
  }
  if (stats.missed_cycles + stats.caught_up_cycles > 0) {
    text += fmt::format("cycles missed: {} skipped, {} caught up; causes: {}\n", stats.missed_cycles, stats.caught_up_cycles,
                        describe_causes(stats));
  }
  if (scheduling.is_known) text += describe_scheduling(scheduling);
  text += describe_hops(stats);
  if (stats.bare_echo.count() > 0 && stats.round_trip.count() > 0) {
    text += fmt::format("the round trip takes {:.2f} times as long as the bare echo at p50, {:.2f} times at p99\n",
                        stats.round_trip.quantile_ns(0.5) / stats.bare_echo.quantile_ns(0.5),
                        stats.round_trip.quantile_ns(0.99) / stats.bare_echo.quantile_ns(0.99));
  }
  return text;
}

}  // namespace hapton
