// Shows: a program that moves an object of the scene. It lifts an object that has moved_by = "program" by 20 mm and puts it back, again and
//        again, and says how long each move takes.
// Run:   io_node; haptics_node --scene scenes/lift.toml; move_object [SECONDS [HUB [KEYFILE]]]
#include <cstdio>
#include <cstdlib>

#include "link/hub_connection.h"
#include "link/move_request.h"

using namespace hapton;

// A motion of 20 mm in 10 ms would be 2 m/s: the haptics node slows it to 0.25 m/s.
constexpr double kRequestedS = 0.01;

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10.0;
  auto hub = HubConnection::open(NodeRole::tool, {.hub = argc > 2 ? argv[2] : "127.0.0.1", .key_file = argc > 3 ? argv[3] : ""});
  if (!hub) return std::fprintf(stderr, "%s\n", hub.error().what.c_str()), 1;
  if (const auto joined = (*hub)->wait_until_joined(5.0); !joined) return std::fprintf(stderr, "%s\n", joined.error().what.c_str()), 1;

  HubClient& client = (*hub)->client();
  const Clock& clock = (*hub)->clock();
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  Datagram datagram;
  int moves = 0;
  while (clock.now_ns() < end_ns || moves == 0) {
    // A position like position_m in the scene file. The rotation is left out: the object does not turn.
    const Vec3 to(-0.05, moves % 2 == 0 ? 0.0 : -0.02, 0.0);
    const auto request = make_move_request("platform", {.position_m = to, .over_s = kRequestedS});
    if (!request) return std::fprintf(stderr, "%s\n", request.error().what.c_str()), 1;
    const auto takes_s = move_object(client, clock, *request, 30.0);
    if (!takes_s) return std::fprintf(stderr, "%s\n", takes_s.error().what.c_str()), 1;
    std::printf("move %d takes %.3f s\n", ++moves, *takes_s);
    // The hub drops a node that sends nothing: receive() sends Hello messages while the object moves.
    const std::int64_t next_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * (*takes_s + 0.2));
    while (clock.now_ns() < next_ns) client.receive(datagram, next_ns);
  }
  return 0;
}
