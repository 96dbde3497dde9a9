#pragma once

#include <algorithm>
#include <cstring>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "link/codec.h"
#include "link/endpoint.h"
#include "runtime/clock.h"

namespace hapton {

// The hub's network endpoint in a test that plays all other nodes: on_send gets each datagram that the hub sends; the agenda holds the
// datagrams that the hub will receive, with their times of arrival. Waiting advances the simulated clock.
class ScriptedEndpoint final : public Endpoint {
 public:
  explicit ScriptedEndpoint(SimulatedClock& clock) : clock_(clock) {}

  std::function<void(const Address& to, const Datagram&)> on_send;
  // Gets the bytes of everything that the hub sends, also if they are not a datagram of ours.
  std::function<void(const Address& to, std::span<const std::byte>)> on_send_raw;

  // The role of the key with which datagrams from this address are sealed. Not set: they are not sealed.
  std::function<KeyRole(const Address& from)> key_role_of;

  void arrive(std::int64_t when_ns, const Address& from, const Datagram& datagram) {
    std::vector<std::byte> bytes(kMaxDatagramBytes);
    bytes.resize(codec_.encode(datagram, bytes));
    arrive_raw(when_ns, from, bytes);
  }
  void arrive_raw(std::int64_t when_ns, const Address& from, std::span<const std::byte> bytes) {
    agenda_.push_back({when_ns, count_++, from, {bytes.begin(), bytes.end()}});
    std::sort(agenda_.begin(), agenda_.end(),
              [](const Item& a, const Item& b) { return a.when_ns != b.when_ns ? a.when_ns > b.when_ns : a.order > b.order; });
  }

  bool send(const Address& to, std::span<const std::byte> bytes) noexcept override {
    Datagram datagram;
    if (on_send_raw) on_send_raw(to, bytes);
    if (on_send && codec_.decode(bytes, datagram) == DecodeStatus::ok) on_send(to, datagram);
    return true;
  }

  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    const bool in_time = !agenda_.empty() && agenda_.back().when_ns <= std::max(deadline_ns, clock_.now_ns());
    if (!in_time) {
      clock_.sleep_until_ns(deadline_ns);
      return {};
    }
    const Item item = agenda_.back();
    agenda_.pop_back();
    clock_.sleep_until_ns(item.when_ns);
    std::memcpy(into.data(), item.bytes.data(), std::min(into.size(), item.bytes.size()));
    return {item.bytes.size(), item.from, key_role_of ? key_role_of(item.from) : KeyRole::unsealed};
  }

  Address local_address() const override { return {{}, 4950}; }

  // The flood that a sealed endpoint would report.
  std::optional<Flood> flood;
  std::optional<Flood> take_flood(std::int64_t) noexcept override { return std::exchange(flood, std::nullopt); }
  SealCounts seal;
  SealCounts seal_counts() const noexcept override { return seal; }

 private:
  struct Item {
    std::int64_t when_ns;
    int order;
    Address from;
    std::vector<std::byte> bytes;
  };
  SimulatedClock& clock_;
  Codec codec_;
  std::vector<Item> agenda_;
  int count_ = 0;
};

}  // namespace hapton
