// Shows: how old a sample is when a program has it, on the hub's host, beside the round trip of the forces that the hub measures.
// Run:   io_node; haptics_node; latency_probe [SECONDS [HUB [KEYFILE]]]
#include <cstdio>
#include <cstdlib>

#include "link/hub_connection.h"
#include "runtime/latency_histogram.h"

using namespace hapton;

int main(int argc, char** argv) {
  const double seconds = argc > 1 ? std::atof(argv[1]) : 10.0;
  auto hub = HubConnection::open(NodeRole::vision, {.hub = argc > 2 ? argv[2] : "127.0.0.1", .key_file = argc > 3 ? argv[3] : ""});
  if (!hub) return std::fprintf(stderr, "%s\n", hub.error().what.c_str()), 1;
  if (const auto joined = (*hub)->wait_until_joined(5.0); !joined) return std::fprintf(stderr, "%s\n", joined.error().what.c_str()), 1;

  HubClient& client = (*hub)->client();
  const Clock& clock = (*hub)->clock();
  const std::int64_t end_ns = clock.now_ns() + static_cast<std::int64_t>(1e9 * seconds);
  LatencyHistogram ages;
  ProbeState newest;
  Datagram datagram;
  while (clock.now_ns() < end_ns) {
    if (!client.receive(datagram, end_ns)) continue;
    const auto* probe = std::get_if<ProbeState>(&datagram.message);
    if (probe == nullptr || client.last_arrival() == Arrival::reordered) continue;
    newest = *probe;
    // CLOCK_MONOTONIC is one clock for all programs of a host. From another host only the round trip that the hub measures is valid.
    ages.record(client.receive_time_ns() - probe->sample_time_ns);
    // Requests the next state; without this the hub only sends states ten times a second.
    client.send(FrameAck{.echo_sample = probe->sample, .echo_sample_time_ns = probe->sample_time_ns});
  }
  std::printf("%llu samples, age p50 %.1f us, p99 %.1f us, max %.1f us\n", static_cast<unsigned long long>(ages.count()),
              1e-3 * ages.quantile_ns(0.5), 1e-3 * ages.quantile_ns(0.99), 1e-3 * static_cast<double>(ages.max_ns()));
  std::printf("round trip of the forces, by the hub: p50 %.1f us, p99 %.1f us at %.0f Hz\n", newest.round_trip_p50_us,
              newest.round_trip_p99_us, newest.servo_rate_hz);
  return ages.count() > 0 ? 0 : 1;
}
