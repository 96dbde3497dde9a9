#include "io_node/io_report.h"

#include <fmt/core.h>

namespace hapton {
namespace {

std::int64_t whole(std::uint64_t count) { return static_cast<std::int64_t>(count); }

double per_second(std::uint64_t count, const ServoStats& stats) {
  return stats.seconds() > 0.0 ? static_cast<double>(count) / stats.seconds() : 0.0;
}

void add_counters(LatencyReport& report, const ServoStats& s) {
  const auto rejected = s.hub.undecodable + s.hub.other_session + s.hub.strangers + s.hub.misplaced;
  report.counters = {{"samples", whole(s.samples)},
                     {"states_sent", whole(s.states_sent)},
                     {"forces", whole(s.forces)},
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
                     {"silence_events", whole(s.guard.silences)},
                     {"clamped", whole(s.guard.clamped)},
                     {"slewed", whole(s.guard.slewed)},
                     {"not_finite", whole(s.guard.not_finite)},
                     {"refused_old", whole(s.guard.refused_old)},
                     {"caught_up_cycles", whole(s.caught_up_cycles)},
                     {"missed_late_wake_up", whole(missed_by(s, MissCause::late_wake_up))},
                     {"missed_device_slow", whole(missed_by(s, MissCause::device_slow))},
                     {"missed_work_long", whole(missed_by(s, MissCause::work_long))},
                     {"missed_machine_stalled", whole(missed_by(s, MissCause::machine_stalled))},
                     {"refused_future", whole(s.guard.refused_future)},
                     {"datagrams_received", whole(s.hub.received)},
                     {"datagrams_rejected", whole(rejected)},
                     {"joins_refused", whole(s.hub.refusals)},
                     {"peers_timed_out", whole(s.hub.timeouts)},
                     {"bad_settings", whole(s.bad_settings)},
                     {"vision_sent", whole(s.probe_states_sent)},
                     {"views_forwarded", whole(s.views_forwarded)},
                     {"drawn", whole(s.drawn)},
                     {"echo_sent", whole(s.echo.sent)},
                     {"echo_answered", whole(s.echo.answered)},
                     {"echo_late", whole(s.echo.late)},
                     {"events_dropped", whole(s.events_dropped)}};
}

void add_ratio(LatencyReport& report, const ServoStats& stats, const char* name, double fraction) {
  const double echo_ns = stats.bare_echo.quantile_ns(fraction);
  if (stats.round_trip.count() > 0 && echo_ns > 0.0) report.ratios[name] = stats.round_trip.quantile_ns(fraction) / echo_ns;
}

}  // namespace

LatencyReport make_io_report(const ServoStats& stats, const IoOptions& options, const std::string& realtime) {
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
  add_ratio(report, stats, "round_trip_over_echo_p50", 0.5);
  add_ratio(report, stats, "round_trip_over_echo_p99", 0.99);
  report.notes = {{"bind", options.bind},
                  {"device", options.device},
                  {"realtime", realtime},
                  {"seed", std::to_string(options.seed)},
                  {"max_force_written_n", fmt::format("{:.3f}", stats.max_force_n)}};
  if (!options.trajectory.empty()) report.notes["trajectory"] = options.trajectory;
  if (!options.echo_probe.empty()) report.notes["echo_probe"] = options.echo_probe;
  report.hops = {{"round_trip", stats.round_trip},
                 {"haptics_compute", stats.haptics_compute},
                 {"wire", stats.wire},
                 {"force_age", stats.force_age},
                 {"wake_lateness", stats.wake_lateness},
                 {"device_read", stats.device_read},
                 {"device_to_drawn", stats.device_to_drawn}};
  if (!options.echo_probe.empty()) report.hops.push_back({"bare_echo", stats.bare_echo});
  return report;
}

std::string describe_run(const ServoStats& s) {
  const auto us = [](const LatencyHistogram& h, double fraction) { return 1e-3 * h.quantile_ns(fraction); };
  std::string text = fmt::format("{:.1f} s, {} samples ({:.0f} Hz), {} forces, {} in contact, strongest {:.2f} N\n", s.seconds(), s.samples,
                                 per_second(s.samples, s), s.forces, s.contact_samples, s.max_force_n);
  text += fmt::format("late {}, lost {}, superseded {}, reordered {}, missed cycles {}, silences {}, clamped {}, slewed {}\n",
                      s.ledger.late, s.ledger.lost, s.ledger.superseded, s.ledger.reordered, s.missed_cycles, s.guard.silences,
                      s.guard.clamped, s.guard.slewed);
  if (s.missed_cycles + s.caught_up_cycles > 0) {
    text += fmt::format("cycles missed: {} skipped, {} caught up; causes: {}\n", s.missed_cycles, s.caught_up_cycles, describe_causes(s));
  }
  text += fmt::format("round trip p50 {:.1f} us, p99 {:.1f} us, p99.9 {:.1f} us\n", us(s.round_trip, 0.5), us(s.round_trip, 0.99),
                      us(s.round_trip, 0.999));
  if (s.bare_echo.count() > 0 && s.round_trip.count() > 0) {
    text += fmt::format("bare echo  p50 {:.1f} us, p99 {:.1f} us: the round trip is {:.2f} times as long at p50\n", us(s.bare_echo, 0.5),
                        us(s.bare_echo, 0.99), us(s.round_trip, 0.5) / us(s.bare_echo, 0.5));
  }
  return text;
}

}  // namespace hapton
