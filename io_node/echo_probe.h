#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "link/endpoint.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// Measures the bare echo of the same machine in the same run: sends a datagram of a DeviceState's length to a responder that returns it
// (hapton echo), and waits for it as the network side waits for its force. The ratio of the force round trip to the echo is the cost of the
// system itself. RT: probe yes; making one is set-up only. Threads: the network side's.
class EchoProbe {
 public:
  struct Counts {
    std::uint64_t sent = 0;
    std::uint64_t replied = 0;
    std::uint64_t late = 0;     // came after its wait was over
    std::uint64_t foreign = 0;  // not what we sent
  };

  // bytes: of a datagram, 0: as many as a DeviceState has on the wire; fewer than 16 are 16.
  // Pre: endpoint and clock outlive this; the endpoint is the probe's own; bytes at most kMaxDatagramBytes.
  EchoProbe(Endpoint& endpoint, const Clock& clock, const Address& responder, std::size_t bytes = 0);

  // One echo; waits no longer than until deadline_ns.
  void probe(std::int64_t deadline_ns) noexcept;

  const LatencyHistogram& round_trip() const noexcept { return round_trip_; }
  const Counts& counts() const noexcept { return counts_; }

 private:
  Endpoint& endpoint_;
  const Clock& clock_;
  Address responder_;
  std::array<std::byte, kMaxDatagramBytes> out_ = {};
  std::array<std::byte, kMaxDatagramBytes> in_ = {};
  std::size_t bytes_ = 0;
  std::uint64_t sequence_ = 0;
  LatencyHistogram round_trip_;
  Counts counts_;
};

}  // namespace hapton
