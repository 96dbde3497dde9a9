#include "link/memory_endpoint.h"

#include <algorithm>
#include <map>
#include <random>
#include <vector>

#include "link/udp_endpoint.h"

namespace hapton {
namespace {

using Key = std::pair<std::array<std::uint8_t, 16>, std::uint16_t>;

Key key_of(const Address& address) { return {address.ip, address.port}; }

struct InFlight {
  std::int64_t arrives_ns = 0;
  std::uint64_t order = 0;  // breaks ties: the datagram sent first arrives first
  Address from;
  std::vector<std::byte> bytes;
};

bool arrives_before(const InFlight& a, const InFlight& b) {
  return a.arrives_ns != b.arrives_ns ? a.arrives_ns < b.arrives_ns : a.order < b.order;
}

}  // namespace

struct MemoryNetwork::State {
  Clock& clock;
  Impairments impairments;
  std::mt19937_64 random;
  std::map<Key, std::vector<InFlight>> inboxes;
  std::uint64_t order = 0;

  State(Clock& clock_in, const Impairments& impairments_in) : clock(clock_in), impairments(impairments_in), random(impairments_in.seed) {}

  bool happens(double probability) { return std::uniform_real_distribution<double>(0.0, 1.0)(random) < probability; }

  std::int64_t draw_arrival_ns() {
    std::int64_t delay_ns = impairments.delay_ns;
    if (impairments.jitter_ns > 0) {
      delay_ns += std::uniform_int_distribution<std::int64_t>(0, impairments.jitter_ns)(random);
    }
    if (happens(impairments.reorder)) {
      delay_ns += impairments.reorder_by_ns;
    }
    return clock.now_ns() + delay_ns;
  }

  void deliver(const Address& from, const Address& to, std::span<const std::byte> datagram) {
    const auto inbox = inboxes.find(key_of(to));
    if (inbox == inboxes.end() || happens(impairments.loss)) {
      return;
    }
    const int copies = happens(impairments.duplicate) ? 2 : 1;
    for (int copy = 0; copy < copies; ++copy) {
      inbox->second.push_back({draw_arrival_ns(), order++, from, {datagram.begin(), datagram.end()}});
    }
  }
};

namespace {

class MemoryEndpoint final : public Endpoint {
 public:
  MemoryEndpoint(std::shared_ptr<MemoryNetwork::State> state, const Address& local) : state_(std::move(state)), local_(local) {}
  ~MemoryEndpoint() override { state_->inboxes.erase(key_of(local_)); }

  bool send(const Address& to, std::span<const std::byte> datagram) noexcept override {
    if (datagram.size() > kMaxDatagramBytes) {
      return false;
    }
    state_->deliver(local_, to, datagram);
    return true;
  }

  Received receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept override {
    std::vector<InFlight>& inbox = state_->inboxes.at(key_of(local_));
    while (true) {
      const auto next = std::min_element(inbox.begin(), inbox.end(), arrives_before);
      if (next == inbox.end() || next->arrives_ns > std::max(deadline_ns, state_->clock.now_ns())) {
        state_->clock.sleep_until_ns(deadline_ns);
        return {};
      }
      state_->clock.sleep_until_ns(next->arrives_ns);
      const InFlight datagram = std::move(*next);
      inbox.erase(next);
      if (!datagram.bytes.empty() && datagram.bytes.size() <= into.size()) {
        std::copy(datagram.bytes.begin(), datagram.bytes.end(), into.begin());
        return {.bytes = datagram.bytes.size(), .from = datagram.from};
      }
    }
  }

  Address local_address() const override { return local_; }

 private:
  std::shared_ptr<MemoryNetwork::State> state_;
  Address local_;
};

}  // namespace

MemoryNetwork::MemoryNetwork(Clock& clock, const Impairments& impairments) : state_(std::make_shared<State>(clock, impairments)) {}

Result<std::unique_ptr<Endpoint>> MemoryNetwork::open(const Address& address) {
  Address local = address;
  if (local.port == 0) {
    local.port = 49152;  // the first dynamic port (RFC 6335)
    while (state_->inboxes.contains(key_of(local))) {
      ++local.port;
    }
  }
  if (!state_->inboxes.try_emplace(key_of(local)).second) {
    return fail("memory network: address {} is taken; choose another", to_string(local));
  }
  return std::make_unique<MemoryEndpoint>(state_, local);
}

void MemoryNetwork::set_impairments(const Impairments& impairments) { state_->impairments = impairments; }

Address memory_address(std::uint8_t host, std::uint16_t port) {
  Address address;
  address.ip = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF, 10, 0, 0, host};
  address.port = port;
  return address;
}

}  // namespace hapton
