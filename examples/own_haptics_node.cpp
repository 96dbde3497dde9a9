// Shows: a haptics node of your own. The hand is on a spring to a point; io_node's governor limits what you reply, as it does for
// haptics_node. Run:   io_node, and in another terminal: own_haptics_node [SECONDS [HUB [KEYFILE]]]
#include <cstdio>
#include <cstdlib>

#include "link/hub_connection.h"
#include "runtime/realtime.h"

using namespace hapton;

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10.0;
  auto hub = HubConnection::open(NodeRole::haptics,
                                 {.hub = argc > 2 ? argv[2] : "127.0.0.1", .key_file = argc > 3 ? argv[3] : "", .has_worker = true});
  if (!hub) return std::fprintf(stderr, "%s\n", hub.error().what.c_str()), 1;
  if (const auto rights = enter_realtime({}); rights) std::printf("%s\n", rights->to_text().c_str());
  if (const auto joined = (*hub)->wait_until_joined(5.0); !joined) return std::fprintf(stderr, "%s\n", joined.error().what.c_str()), 1;

  HubClient& client = (*hub)->client();
  const Clock& clock = (*hub)->clock();
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  Datagram datagram;
  ForceCommand reply;
  std::uint64_t replies = 0;
  std::uint64_t superseded = 0;
  while (clock.now_ns() < end_ns) {
    // No timer: the device's samples set the pace. The wait ends after 50 ms, so that this loop ends in time, even without a hub.
    if (!client.receive(datagram, clock.now_ns() + 50 * kNanosecondsPerMillisecond)) continue;
    std::optional<DeviceState> newest;
    std::uint32_t states = 0;
    do {  // drain: a reply to an older sample would only be late
      const auto* state = std::get_if<DeviceState>(&datagram.message);
      if (state == nullptr || client.last_arrival() == Arrival::reordered) continue;
      newest = *state;
      ++states;
    } while (client.receive(datagram, 0));
    if (!newest) continue;

    reply.force_n = -150.0 * newest->p_WD;  // your force, N, frame W
    const std::uint64_t sample_step = newest->sample - reply.echo_sample;
    // Bit i: sample echo_sample - 1 - i got a reply as well. From these bits the hub counts lost replies.
    reply.replied_before =
        replies == 0 || sample_step - 1 >= 63 ? 0 : reply.replied_before << sample_step | std::uint64_t{1} << (sample_step - 1);
    reply.echo_sample = newest->sample;
    reply.echo_sample_time_ns = newest->sample_time_ns;  // so that the hub measures the round trip on its own clock
    reply.skipped_samples = states - 1;
    reply.compute_ns = static_cast<std::uint32_t>(clock.now_ns() - client.receive_time_ns());
    client.send(reply);
    superseded += states - 1;
    ++replies;
  }
  std::printf("%llu forces, %.0f a second; %llu samples superseded\n", static_cast<unsigned long long>(replies),
              static_cast<double>(replies) / seconds, static_cast<unsigned long long>(superseded));
  return replies > 0 ? 0 : 1;
}
