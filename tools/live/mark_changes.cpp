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
    const auto said = reply != nullptr ? marker.take(*reply) : std::nullopt;
    if (said) fmt::print("{}\n", *said);
    if (said) std::fflush(stdout);
  }
}

std::uint64_t count_unseen(DigitalLine& line, const LineMarker& marker) {
  const auto all = line.changes();
  return all && *all > marker.counts().changes ? *all - marker.counts().changes : 0;
}

}  // namespace

Result<std::uint64_t> mark_changes(DigitalLine& line, LineMarker& marker, HubClient& client, const Clock& clock,
                                   const std::function<bool()>& goes_on) {
  Result<bool> level = false;
  while (level && goes_on()) {
    level = line.is_on();
    if (level) marker.see(*level, clock.now_ns());
    exchange_markers(marker, client, clock);
  }
  const std::uint64_t unseen = count_unseen(line, marker);
  while (marker.is_waiting()) exchange_markers(marker, client, clock);
  if (!level) return tl::unexpected(level.error());
  return unseen;
}

}  // namespace hapton
