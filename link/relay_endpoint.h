#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "link/endpoint.h"
#include "link/fault_schedule.h"

namespace hapton {

struct RelaySettings {
  std::string listen = "127.0.0.1:0";  // address at which the nodes find the hub
  Address hub;
  FaultSchedule schedule;
  std::uint64_t seed = 1;
};

// Counters of the datagrams of one direction.
struct RelayCounts {
  std::uint64_t received = 0;
  std::uint64_t forwarded = 0;      // copies included
  std::uint64_t lost = 0;           // at random, independently
  std::uint64_t lost_in_burst = 0;  // within a burst
  std::uint64_t partitioned = 0;
  std::uint64_t held_back = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t corrupted = 0;
  std::uint64_t overflowed = 0;  // the queue was full
  std::uint64_t rejected = 0;    // too long, or from a node beyond kMaxClients
  std::uint64_t send_failures = 0;
};

// A bad network between the nodes and their hub: a UDP relay that loses, delays, reorders, duplicates and corrupts what it forwards,
// by the schedule and the seed. It forwards bytes without decoding them. The hub sees a different port for each node. Bounded:
// at most kMaxQueued datagrams wait, at most kMaxClients nodes are known; a node idle for kIdleNs is replaced by a new one. RT: no.
// Threads: one.
class RelayEndpoint {
 public:
  static constexpr std::size_t kMaxQueued = 16'384;  // a choice: 32 MiB at most, and over a second of 10 kHz in one direction
  static constexpr std::size_t kMaxClients = 64;
  static constexpr std::size_t kMaxBytes = 2048;           // the largest datagram that is forwarded
  static constexpr std::int64_t kIdleNs = 10'000'000'000;  // a choice: a node sends ten times a second

  // Error, one line: bad address, port in use, or a phase of the schedule with invalid faults.
  static Result<RelayEndpoint> open(RelaySettings settings);

  ~RelayEndpoint();
  RelayEndpoint(RelayEndpoint&&) noexcept;
  RelayEndpoint& operator=(RelayEndpoint&&) = delete;

  // Forwards for the given time. The schedule started when the relay was opened.
  void run_for_ns(std::int64_t duration_ns);

  const Address& local_address() const;
  const RelayCounts& to_hub() const;
  const RelayCounts& to_nodes() const;
  // The number of nodes seen so far; one that was replaced while idle and comes back counts again.
  std::uint64_t clients() const;
  // The index of the present phase in the schedule, or one past the last.
  std::size_t phase() const;

 private:
  struct State;
  explicit RelayEndpoint(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace hapton
