#pragma once

#include <algorithm>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <vector>

#include "link/endpoint.h"
#include "link/fault_injector.h"
#include "runtime/clock.h"

namespace hapton {

// A star of one hub and any number of nodes on one simulated clock and one thread. The hub's loop drives it: while the hub waits, time
// advances from event to event, and a node whose datagram or time has come gets its turn. Each direction has its own FaultInjector.
class SimulatedNetwork {
 public:
  static constexpr std::int64_t kTurnNs = 20'000'000;   // a node gets a turn at least this often
  static constexpr std::size_t kInboxDatagrams = 4096;  // capacity of a frozen node's socket buffer

  SimulatedNetwork(SimulatedClock& clock, std::uint64_t seed) : clock_(clock), to_hub_(seed), to_nodes_(seed + 1) {}

  void set_faults(const LinkFaults& to_hub, const LinkFaults& to_nodes) {
    to_hub_.set(to_hub);
    to_nodes_.set(to_nodes);
  }

  std::unique_ptr<Endpoint> open_hub(const Address& address) {
    hub_ = address;
    return std::make_unique<Port>(*this, address, true);
  }

  // turn: called whenever a datagram has arrived for the node, and at least every kTurnNs.
  std::unique_ptr<Endpoint> open_node(const Address& address, std::function<void()> turn) {
    nodes_.push_back({address, std::move(turn), clock_.now_ns(), {}, false});
    return std::make_unique<Port>(*this, address, false);
  }

  // Ends a node as a crash ends a process: from now on it sends nothing and nothing arrives at it.
  void kill(const Address& address) {
    std::erase_if(nodes_, [&](const Node& node) { return node.address == address; });
  }

  // Stops or continues a node: datagrams wait meanwhile.
  void freeze(const Address& address, bool is_frozen) {
    Node& node = *find(address);
    node.is_frozen = is_frozen;
    node.next_turn_ns = clock_.now_ns();
  }

  // Runs the nodes until end_ns while the hub is stopped.
  void run_nodes_until(std::int64_t end_ns) {
    while (step_nodes(end_ns)) {
    }
    clock_.sleep_until_ns(end_ns);
  }

  // Puts bytes straight into the hub's buffer, from any address.
  void inject(const Address& from, std::vector<std::byte> bytes) {
    hub_inbox_.push_back({clock_.now_ns(), ++order_, from, hub_, std::move(bytes)});
  }

 private:
  struct InFlight {
    std::int64_t due_ns = 0;
    std::uint64_t order = 0;
    Address from;
    Address to;
    std::vector<std::byte> bytes;
  };
  struct Node {
    Address address;
    std::function<void()> turn;
    std::int64_t next_turn_ns = 0;
    std::deque<InFlight> inbox;
    bool is_frozen = false;
  };

  class Port final : public Endpoint {
   public:
    Port(SimulatedNetwork& network, const Address& address, bool is_hub) : network_(network), address_(address), is_hub_(is_hub) {}
    bool send(const Address& to, std::span<const std::byte> bytes) noexcept override {
      network_.send(address_, to, bytes);
      return true;
    }
    Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
      return is_hub_ ? network_.receive_at_hub(into, deadline_ns) : network_.receive_at_node(address_, into);
    }
    Address local_address() const override { return address_; }

   private:
    SimulatedNetwork& network_;
    Address address_;
    bool is_hub_;
  };

  std::vector<Node>::iterator find(const Address& address) {
    return std::find_if(nodes_.begin(), nodes_.end(), [&](const Node& node) { return node.address == address; });
  }

  void send(const Address& from, const Address& to, std::span<const std::byte> bytes) {
    const bool is_to_hub = to == hub_;
    if (is_to_hub && find(from) == nodes_.end()) return;
    const Fate fate = (is_to_hub ? to_hub_ : to_nodes_).draw(clock_.now_ns());
    if (fate.kind != Fate::Kind::passed) return;
    std::vector<std::byte> copy(bytes.begin(), bytes.end());
    if (fate.corrupt) damage_bytes(copy, fate.damage);
    for (std::size_t n = 0; n < fate.copies; ++n) in_flight_.push_back({fate.due_ns[n], ++order_, from, to, copy});
  }

  static Received hand_out(std::deque<InFlight>& inbox, std::span<std::byte> into) {
    if (inbox.empty()) return {};
    const InFlight datagram = std::move(inbox.front());
    inbox.pop_front();
    const std::size_t bytes = std::min(into.size(), datagram.bytes.size());
    std::memcpy(into.data(), datagram.bytes.data(), bytes);
    return {bytes, datagram.from};
  }

  Received receive_at_node(const Address& address, std::span<std::byte> into) {
    const auto node = find(address);
    return node == nodes_.end() ? Received() : hand_out(node->inbox, into);
  }

  Received receive_at_hub(std::span<std::byte> into, std::int64_t deadline_ns) {
    while (hub_inbox_.empty() && step_nodes(std::max(deadline_ns, clock_.now_ns()))) {
    }
    if (hub_inbox_.empty()) clock_.sleep_until_ns(deadline_ns);
    return hand_out(hub_inbox_, into);
  }

  // Runs the next event up to end_ns; false if there is none.
  bool step_nodes(std::int64_t end_ns) {
    const auto arrival = std::min_element(in_flight_.begin(), in_flight_.end(), [](const InFlight& a, const InFlight& b) {
      return a.due_ns != b.due_ns ? a.due_ns < b.due_ns : a.order < b.order;
    });
    const auto turn = std::min_element(nodes_.begin(), nodes_.end(), [](const Node& a, const Node& b) {
      return (a.is_frozen ? INT64_MAX : a.next_turn_ns) < (b.is_frozen ? INT64_MAX : b.next_turn_ns);
    });
    const std::int64_t arrival_ns = arrival == in_flight_.end() ? INT64_MAX : arrival->due_ns;
    const std::int64_t turn_ns = turn == nodes_.end() || turn->is_frozen ? INT64_MAX : turn->next_turn_ns;
    if (std::min(arrival_ns, turn_ns) > end_ns) return false;
    clock_.sleep_until_ns(std::min(arrival_ns, turn_ns));
    if (arrival_ns <= turn_ns) {
      InFlight datagram = std::move(*arrival);
      in_flight_.erase(arrival);
      deliver(std::move(datagram));
    } else {
      give_turn(*turn);
    }
    return true;
  }

  void deliver(InFlight datagram) {
    if (datagram.to == hub_) return hub_inbox_.push_back(std::move(datagram));
    const auto node = find(datagram.to);
    if (node == nodes_.end() || node->inbox.size() >= kInboxDatagrams) return;
    node->inbox.push_back(std::move(datagram));
    if (!node->is_frozen) give_turn(*node);
  }

  void give_turn(Node& node) {
    node.next_turn_ns = clock_.now_ns() + kTurnNs;
    node.turn();
  }

  SimulatedClock& clock_;
  FaultInjector to_hub_;
  FaultInjector to_nodes_;
  Address hub_;
  std::deque<InFlight> hub_inbox_;
  std::vector<Node> nodes_;
  std::vector<InFlight> in_flight_;
  std::uint64_t order_ = 0;
};

}  // namespace hapton
