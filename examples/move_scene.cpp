// Shows: a program that moves the whole scene. It turns it once about the vertical axis, and waits until forces are computed with the last
// pose.
// Run:   io_node; haptics_node --scene FILE; move_scene [SECONDS [HUB [KEYFILE]]]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "link/hub_connection.h"

using namespace hapton;

// A rotation about y, as the rows of [R|t].
ViewTransform turn_about_y(std::uint32_t revision, double angle_rad) {
  const auto c = static_cast<float>(std::cos(angle_rad));
  const auto s = static_cast<float>(std::sin(angle_rad));
  return {.revision = revision, .X_WS = {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0}};
}

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10.0;
  // The hub accepts poses of the scene only from vision nodes.
  auto hub = HubConnection::open(NodeRole::vision, {.hub = argc > 2 ? argv[2] : "127.0.0.1", .key_file = argc > 3 ? argv[3] : ""});
  if (!hub) return std::fprintf(stderr, "%s\n", hub.error().what.c_str()), 1;
  if (const auto joined = (*hub)->wait_until_joined(5.0); !joined) return std::fprintf(stderr, "%s\n", joined.error().what.c_str()), 1;

  HubClient& client = (*hub)->client();
  const Clock& clock = (*hub)->clock();
  // Revisions continue from the one in use, which the hub's first state gives.
  std::uint32_t start_revision = 0;
  Datagram datagram;
  for (const std::int64_t end_ns = clock.now_ns() + kNanosecondsPerSecond; clock.now_ns() < end_ns;) {
    if (!client.receive(datagram, end_ns)) continue;
    if (const auto* view = std::get_if<ViewTransform>(&datagram.message)) start_revision = view->revision;
    const auto* probe = std::get_if<ProbeState>(&datagram.message);
    if (probe == nullptr) continue;
    start_revision = std::max(start_revision, probe->view_revision);
    break;
  }
  const auto moves = static_cast<std::uint32_t>(50.0 * seconds);  // 50 a second: small steps, as a hand may be in contact
  std::uint32_t felt_revision = start_revision;
  std::int64_t next_ns = clock.now_ns();
  for (std::uint32_t k = 1; k <= moves || (felt_revision < start_revision + moves && k < moves + 100); ++k) {
    // Only the newest pose counts. The last one is sent again until forces use it, in case a datagram was lost.
    const std::uint32_t revision = std::min(k, moves);
    client.send(turn_about_y(start_revision + revision, 2.0 * std::numbers::pi * revision / moves));
    next_ns += 20 * kNanosecondsPerMillisecond;
    while (client.receive(datagram, next_ns)) {
      if (std::holds_alternative<ViewRejected>(datagram.message)) return std::fprintf(stderr, "the pose is not rigid\n"), 1;
      if (const auto* probe = std::get_if<ProbeState>(&datagram.message)) felt_revision = probe->view_revision;
    }
  }
  std::printf("%u poses sent; the forces are those of pose %u\n", moves, felt_revision - start_revision);
  return felt_revision == start_revision + moves ? 0 : 1;
}
