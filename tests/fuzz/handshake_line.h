#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "link/sealed_client.h"
#include "link/sealed_hub.h"
#include "runtime/clock.h"
#include "tests/fuzz/datagram_list.h"

// A hub and one node that has requested a session, the same in every run; and handshake messages as the holder of the master key makes
// them.
namespace hapton::fuzz {

// Records what is sent. receive() returns the datagram of the last hold(), once.
class OneDatagramEndpoint final : public Endpoint {
 public:
  explicit OneDatagramEndpoint(const Address& at) : at_(at) {}
  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override;
  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override;
  Address local_address() const override { return at_; }

  // Pre: `datagram` is no longer than kMaxDatagramBytes.
  void hold(const Bytes& datagram, const Address& from);

  struct Sent {
    Address to;
    Bytes bytes;
  };
  std::vector<Sent> sent;

 private:
  Address at_;
  Bytes datagram_;
  Address from_;
};

class HandshakeLine {
 public:
  HandshakeLine();

  // Waits for the pause of the datagram, then delivers it. Returns how many bytes the receiver handed out, though none were ever sent.
  std::size_t deliver(const ListedDatagram& datagram);

  const Clock& clock() const { return clock_; }
  const SealedHub& hub() const { return hub_; }
  const SealedClient& node() const { return node_; }
  // The datagrams that were sent, the newest last.
  const std::vector<OneDatagramEndpoint::Sent>& from_hub() const { return hub_end_.sent; }
  const std::vector<OneDatagramEndpoint::Sent>& from_node() const { return node_end_.sent; }

 private:
  SimulatedClock clock_;
  OneDatagramEndpoint hub_end_;
  OneDatagramEndpoint node_end_;
  SealedHub hub_;
  SealedClient node_;
};

// Whether it is a request, a retry or a reply, by its kind and length. Whether it has the tag that the key of its role gives.
std::optional<seal::Kind> find_handshake_kind(const Bytes& datagram);
bool has_tag(const Bytes& datagram, KeyRole node_role);

// Messages as the holder of the keys makes them: with the right tag, and a Noise message that fits. Pre: FixedRandom::install().
Bytes make_request(KeyRole role, std::uint64_t host, std::int64_t timestamp_ns, const seal::Cookie& cookie);
Bytes make_retry(std::int64_t timestamp_ns, const seal::Cookie& cookie, KeyRole role);
std::optional<Bytes> make_reply(const Bytes& request, std::uint32_t connection);
// The cookie that the hub of every HandshakeLine issues to that node at that time.
seal::Cookie find_cookie(std::uint8_t node, std::int64_t now_ns);

// Changes one message of a list of handshake messages. That message then has a valid tag, and mostly a valid Noise message, cookie and
// timestamp, as if its sender held the keys.
Bytes mutate_handshakes(std::span<const std::uint8_t> input, Mutation& mutation);
Bytes cross_handshakes(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation);

}  // namespace hapton::fuzz
