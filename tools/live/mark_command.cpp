#include <fmt/core.h>

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "link/hub_connection.h"
#include "link/marker_request.h"
#include "runtime/realtime.h"
#include "runtime/stop_signal.h"
#include "tools/commands.h"
#include "tools/live/mark_changes.h"
#include "tools/live/marker_line.h"

namespace hapton {
namespace {

struct MarkOptions {
  std::string text;
  std::string line;  // empty: one marker is sent, at once
  std::string edges = "on";
  double seconds = 0.0;
  HubConnection::Settings hub;
};

constexpr double kMarkJoinTimeoutS = 2.0;  // how long to wait for the hub; this and the next value are free choices
constexpr std::int64_t kMarkReplyTimeoutNs = 2 * kNanosecondsPerSecond;
constexpr std::int64_t kRepeatMarkNs = 100 * kNanosecondsPerMillisecond;  // the marker is sent again, because a datagram may be lost

std::optional<MarkerReply> wait_for_reply(HubClient& client, std::uint32_t request, std::int64_t end_ns) {
  Datagram datagram;
  while (client.receive(datagram, end_ns)) {
    const auto* reply = std::get_if<MarkerReply>(&datagram.message);
    if (reply != nullptr && reply->request == request) return *reply;
  }
  return std::nullopt;
}

Result<std::uint64_t> mark(const MarkOptions& options) {
  const auto marker = make_marker(options.text);
  if (!marker) return tl::unexpected(marker.error());
  const auto connection = HubConnection::open(NodeRole::tool, options.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kMarkJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  HubClient& client = (*connection)->client();
  const Clock& clock = (*connection)->clock();
  const std::int64_t end_ns = clock.now_ns() + kMarkReplyTimeoutNs;
  while (clock.now_ns() < end_ns) {
    client.send(*marker);
    if (const auto reply = wait_for_reply(client, marker->request, clock.now_ns() + kRepeatMarkNs)) return read_reply(*reply);
  }
  return fail("no reply to the marker: the hub is gone, or of an earlier version");
}

constexpr int kLinePriority = 10;  // below all nodes (80), above ordinary programs

// Marks the changes of an input line, until Ctrl-C or until the time is over.
Result<LineMarker::Counts> follow_line(const MarkOptions& options) {
  const auto input = parse_line_input(options.line);
  if (!input) return tl::unexpected(input.error());
  auto marker = make_line_marker(*input, options.edges, options.text);
  if (!marker) return tl::unexpected(marker.error());
  const auto line = open_line_input(*input);
  if (!line) return tl::unexpected(line.error());
  const auto connection = HubConnection::open(NodeRole::tool, options.hub);
  if (!connection) return tl::unexpected(connection.error());
  if (const auto joined = (*connection)->wait_until_joined(kMarkJoinTimeoutS); !joined) return tl::unexpected(joined.error());
  (void)enter_realtime({.mode = RealtimeMode::attempt, .priority = kLinePriority, .lock_memory = false});
  fmt::print("marks {} of {}; Ctrl-C ends it\n", input->name, input->device);
  std::fflush(stdout);
  const StopSignal stop;
  const Clock& clock = (*connection)->clock();
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * options.seconds);
  const auto should_continue = [&] { return !stop.stop_requested() && (options.seconds <= 0.0 || clock.now_ns() < end_ns); };
  const auto missed_changes = mark_changes(**line, *marker, (*connection)->client(), clock, should_continue);
  if (!missed_changes) return tl::unexpected(missed_changes.error());
  if (*missed_changes > 0) fmt::print("{} changes were too short to be seen\n", *missed_changes);
  return marker->counts();
}

int run_line(const MarkOptions& options) {
  const auto counts = follow_line(options);
  if (!counts) {
    fmt::print(stderr, "hapton mark: {}\n", counts.error().what);
    return 1;
  }
  fmt::print("{} changes, {} marked, {} rejected, {} without a reply\n", counts->changes, counts->marked, counts->rejected,
             counts->given_up);
  return counts->rejected + counts->given_up == 0 ? 0 : 1;
}

int run(const MarkOptions& options) {
  if (!options.line.empty()) return run_line(options);
  if (const auto marker = make_marker(options.text); !marker) {
    fmt::print(stderr, "hapton mark: {}\n", marker.error().what);
    return 2;
  }
  const auto sample = mark(options);
  if (!sample) {
    fmt::print(stderr, "hapton mark: {}\n", sample.error().what);
    return 1;
  }
  fmt::print("marked sample {}: {}\n", *sample, options.text);
  return 0;
}

}  // namespace

void add_mark_command(CommandLine app, int& exit_code) {
  auto options = std::make_shared<MarkOptions>();
  const CommandLine command = app.add_subcommand("mark", "Mark the recording of a running session at its newest sample");
  command.add_option("text", options->text,
                     "Text of the marker: one line of at most 160 bytes; with --line, it replaces the name of the line");
  const CommandOption line =
      command.add_option("--line", options->line,
                         "Mark the changes of a port's input until Ctrl-C: DEVICE:PIN, as in /dev/ttyS0:CTS (serial: CTS, DSR, DCD, RI) or "
                         "/dev/parport0:ACK (parallel: ACK, BUSY, PAPEROUT, SELECT, ERROR); or of a VRPN server's button: "
                         "vrpn:NAME@HOST:BUTTON");
  command.add_option("--edges", options->edges, "With --line: mark when it turns on, turns off, or both")
      .one_of({"on", "off", "both"})
      .shows_default()
      .needs(line);
  command.add_option("--seconds", options->seconds, "With --line: end after this long, s; 0: when stopped (Ctrl-C)")
      .between(0.0, 1e9)
      .shows_default()
      .needs(line);
  command.add_option("--hub", options->hub.hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", options->hub.key_file, kKeyHelp);
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
