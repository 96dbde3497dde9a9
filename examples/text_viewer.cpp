// Shows: a vision node of your own, here a line of text ten times a second: where the probe is drawn, what it feels, which buttons are
// down. Run:   io_node; haptics_node; text_viewer [SECONDS [HUB [KEYFILE]]]
#include <cstdio>
#include <cstdlib>

#include "link/hub_connection.h"

using namespace hapton;

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10.0;
  auto hub = HubConnection::open(NodeRole::vision, {.hub = argc > 2 ? argv[2] : "127.0.0.1", .key_file = argc > 3 ? argv[3] : ""});
  if (!hub) return std::fprintf(stderr, "%s\n", hub.error().what.c_str()), 1;
  if (const auto joined = (*hub)->wait_until_joined(5.0); !joined) return std::fprintf(stderr, "%s\n", joined.error().what.c_str()), 1;

  HubClient& client = (*hub)->client();
  const Clock& clock = (*hub)->clock();
  const auto frames = static_cast<int>(10.0 * seconds);
  int drawn = 0;
  std::optional<ProbeState> newest;
  Datagram datagram;
  std::int64_t next_ns = clock.now_ns();
  for (int frame = 0; frame < frames; ++frame) {
    next_ns += 100 * kNanosecondsPerMillisecond;
    while (client.receive(datagram, next_ns)) {
      const auto* probe = std::get_if<ProbeState>(&datagram.message);
      if (probe != nullptr && client.last_arrival() != Arrival::reordered) newest = *probe;
    }
    if (!newest) continue;
    // In contact the probe is drawn on the surface, at the visual offset from the device point.
    const Vec3 p_mm = 1e3 * (newest->p_WD + newest->visual_offset_m);
    const auto bar = static_cast<int>(std::min(40.0, 10.0 * newest->force_n.norm()));
    std::printf("x %6.1f y %6.1f z %6.1f mm  %4.2f N %-40.*s %s buttons %x\n", p_mm.x(), p_mm.y(), p_mm.z(), newest->force_n.norm(), bar,
                "########################################", newest->contact ? "contact" : "free   ", newest->buttons);
    client.send(FrameAck{.echo_sample = newest->sample, .echo_sample_time_ns = newest->sample_time_ns, .frame_rate_hz = 10.0F});
    ++drawn;
  }
  return drawn > 0 ? 0 : 1;
}
