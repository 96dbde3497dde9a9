#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "link/address.h"
#include "link/key_role.h"
#include "link/rejection_monitor.h"
#include "link/seal_counts.h"

namespace hapton {

// The maximum size of every datagram, sealed or not: below the smallest usual MTU (1280, IPv6) less the headers.
constexpr std::size_t kMaxDatagramBytes = 1200;

// A received datagram.
struct Received {
  std::size_t bytes = 0;  // 0: nothing arrived before the deadline
  Address from;
  KeyRole role = KeyRole::unsealed;  // role of the key that sealed it
};

// Counters of the datagrams at a socket that are not data from known peers.
struct SocketCounts {
  std::uint64_t oversized = 0;      // longer than kMaxDatagramBytes, or empty
  std::uint64_t unknown_peers = 0;  // received, but not data from a known peer: handshakes, invalid or oversized datagrams
  std::uint64_t dropped = 0;        // dropped by the kernel: filtered during a flood, or because the socket buffer was full
  std::uint64_t filtered = 0;       // the part of `dropped` while a filter was installed (FloodFilter)
  std::uint64_t floods = 0;         // floods that began
  double flood_per_s = 0.0;         // rate of the newest flood, datagrams a second
  Address last_unknown_sender;
  Address last_oversized;
};

// Exchanges datagrams: over UDP, or in memory for tests; other endpoints wrap one of these. RT: send and receive yes (a few bounded system
// calls each, no heap, lock, log or throw). Threads: one at a time.
class Endpoint {
 public:
  virtual ~Endpoint() = default;

  // Sends one datagram; false if the system rejected it, which the caller counts and which is never fatal.
  virtual bool send(const Address& to, std::span<const std::byte> datagram) noexcept = 0;

  // Waits for a datagram until deadline_ns (CLOCK_MONOTONIC); a deadline in the past polls.
  virtual Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept = 0;

  // Optional: sets a timer in advance for a later receive() with exactly this deadline; the newest two timers are kept. Setting a timer may
  // be slow (5 us on a virtual machine), so a loop calls this outside the interval that it measures.
  virtual void prepare_wait(std::int64_t /*deadline_ns*/) noexcept {}

  virtual Address local_address() const = 0;

  // Optional, set-up only: from now on only datagrams from this address are received; all others are dropped as early as possible. False:
  // not supported.
  virtual bool accept_only(const Address& /*peer*/) noexcept { return false; }

  // Optional: datagrams of this connection number from this address do not count as unknown_peers. RT: yes.
  virtual void expect(const Address& /*from*/, std::uint32_t /*connection*/) noexcept {}

  // The counters of a sealed endpoint; all zero for others.
  virtual SealCounts seal_counts() const noexcept { return {}; }
  // The counters of a socket; all zero for others.
  virtual SocketCounts socket_counts() const noexcept { return {}; }

  // A detected flood of invalid datagrams, to be logged; at most one a second, none for endpoints that are not sealed.
  virtual std::optional<Flood> take_flood(std::int64_t /*now_ns*/) noexcept { return std::nullopt; }
};

}  // namespace hapton
