#include <fmt/core.h>

#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "link/hub_connection.h"
#include "link/marker_request.h"
#include "tools/commands.h"

namespace hapton {
namespace {

struct MarkOptions {
  std::string text;
  HubConnection::Settings hub;
};

constexpr double kJoinPatienceS = 2.0;
constexpr std::int64_t kMarkPatienceNs = 2 * kNanosecondsPerSecond;
constexpr std::int64_t kRepeatMarkNs = 100 * kNanosecondsPerMillisecond;  // a datagram may be lost

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
  if (const auto joined = (*connection)->wait_until_joined(kJoinPatienceS); !joined) return tl::unexpected(joined.error());
  HubClient& client = (*connection)->client();
  const Clock& clock = (*connection)->clock();
  const std::int64_t end_ns = clock.now_ns() + kMarkPatienceNs;
  while (clock.now_ns() < end_ns) {
    client.send(*marker);
    if (const auto reply = wait_for_reply(client, marker->request, clock.now_ns() + kRepeatMarkNs)) return read_reply(*reply);
  }
  return fail("no reply to the marker: the hub is gone, or of an earlier version");
}

int run(const MarkOptions& options) {
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
  command.add_option("text", options->text, "What happened: one line of at most 160 bytes").required();
  command.add_option("--hub", options->hub.hub, "Where io_node is: HOST or HOST:PORT").shows_default();
  command.add_option("--key", options->hub.key_file, kKeyHelp);
  command.on_run([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace hapton
