#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "link/endpoint.h"
#include "runtime/clock.h"
#include "runtime/latency_histogram.h"

namespace hapton {

// Measures the bare echo of the same machine in the same run: sends a datagram of a DeviceState's length to a responder that returns it
// (hapton echo), and waits for it as the network side waits for its force. The ratio of the force round trip to the echo shows the cost of
// Hapton itself. RT: probe and the getters yes; construction set-up only. Threads: the network side's.
class EchoProbe {
 public:
  struct Counts {
    std::uint64_t sent = 0;
    std::uint64_t replied = 0;
    std::uint64_t late = 0;     // echoes that arrived after their wait was over
    std::uint64_t foreign = 0;  // datagrams that are not an echo of this probe
  };

  // bytes: length of a datagram; 0: that of a DeviceState on the wire; less than 16 counts as 16.
  // Pre: endpoint and clock outlive this; the endpoint is the probe's own; bytes at most kMaxDatagramBytes.
  EchoProbe(Endpoint& endpoint, const Clock& clock, const Address& responder, std::size_t bytes = 0);

  // Measures one echo; waits at most until deadline_ns.
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
