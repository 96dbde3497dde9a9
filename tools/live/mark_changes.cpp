#include "tools/live/mark_changes.h"

#include <fmt/core.h>

#include <cstdio>
#include <variant>

namespace hapton {
namespace {

constexpr std::int64_t kLinePollNs = 500'000;  // two polls in each sample period at 1 kHz

// Sends the markers that are due, and takes replies until the next poll of the line.
void exchange_markers(LineMarker& marker, HubClient& client, const Clock& clock) {
  while (const auto next = marker.next(clock.now_ns())) client.send(*next);
  const std::int64_t poll_ns = clock.now_ns() + kLinePollNs;
  Datagram datagram;
  while (client.receive(datagram, poll_ns)) {
    const auto* reply = std::get_if<MarkerReply>(&datagram.message);
    const auto reply_text = reply != nullptr ? marker.take(*reply) : std::nullopt;
    if (reply_text) fmt::print("{}\n", *reply_text);
    if (reply_text) std::fflush(stdout);
  }
}

std::uint64_t count_missed_changes(DigitalLine& line, const LineMarker& marker) {
  const auto counted_changes = line.changes();
  return counted_changes && *counted_changes > marker.counts().changes ? *counted_changes - marker.counts().changes : 0;
}

}  // namespace

Result<std::uint64_t> mark_changes(DigitalLine& line, LineMarker& marker, HubClient& client, const Clock& clock,
                                   const std::function<bool()>& should_continue) {
  Result<bool> level = false;
  while (level && should_continue()) {
    level = line.is_on();
    if (level) marker.observe(*level, clock.now_ns());
    exchange_markers(marker, client, clock);
  }
  const std::uint64_t missed_changes = count_missed_changes(line, marker);
  while (marker.has_pending()) exchange_markers(marker, client, clock);
  if (!level) return tl::unexpected(level.error());
  return missed_changes;
}

}  // namespace hapton
