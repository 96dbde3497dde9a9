#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "core/base/result.h"
#include "link/endpoint.h"

namespace hapton {

// A few TCP connections, and datagrams at the same port: for foreign protocols that need both. Never blocks on a peer: a
// peer that does not read is disconnected when more than kMaxWaitingBytes wait for it, and one whose host no longer replies, for
// example because it was switched off, after kMaxSilentS. RT: no. Threads: one, except wake: any.
class StreamEndpoint {
 public:
  using Id = std::uint64_t;  // names a connection; never used twice
  static constexpr std::size_t kMaxConnections = 16;
  static constexpr std::size_t kMaxWaitingBytes = std::size_t{256} * 1024;
  static constexpr int kMaxSilentS = 20;  // a choice: time enough to plug a cable in again

  // Takes the events. Each connection gets on_connected first and on_closed last; one that connect() began may get on_closed alone.
  struct Listener {
    virtual ~Listener() = default;
    virtual void on_connected(Id id, const Address& peer) = 0;
    virtual void on_bytes(Id id, std::span<const std::byte> bytes) = 0;
    virtual void on_closed(Id id) = 0;
    virtual void on_datagram(const Address& from, std::span<const std::byte> bytes) = 0;
    // Called when all slots are taken and another client connects: returns the connection to close for it; 0: none.
    virtual Id choose_connection_to_evict() { return 0; }
  };

  // Listens at the address, by TCP and UDP; port 0 takes a port that is free for both. [::] serves IPv4 as well. Error, one line:
  // bad address, port in use.
  static Result<std::unique_ptr<StreamEndpoint>> open(std::string_view bind_address, std::uint16_t default_port);

  // Only connects to others: this endpoint does not listen and has no address of its own.
  static Result<std::unique_ptr<StreamEndpoint>> open_to_connect();

  virtual ~StreamEndpoint() = default;

  virtual const Address& local_address() const = 0;

  // Waits for an event, a call of wake, or the deadline (CLOCK_MONOTONIC, ns), and reports all events. The bytes taken from one peer are
  // limited, so that no other peer has to wait.
  virtual void wait(std::int64_t deadline_ns, Listener& listener) = 0;

  // Ends a wait. Threads: any.
  virtual void wake() noexcept = 0;

  // Begins to connect by TCP; 0: no slot is free, or it fails at once.
  virtual Id connect(const Address& to) = 0;

  // False if the connection is gone, or too much waits for it: then it is closed (on_closed comes with the next wait).
  virtual bool send(Id id, std::span<const std::byte> bytes) = 0;
  virtual bool send_datagram(const Address& to, std::span<const std::byte> bytes) = 0;

  // Closes a connection; on_closed comes with the next wait.
  virtual void close(Id id) = 0;
};

}  // namespace hapton
