#include "link/relay_endpoint.h"

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/udp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <map>
#include <queue>
#include <utility>
#include <vector>

#include "link/address_endpoint.h"
#include "link/asio_guard.h"
#include "runtime/clock.h"

namespace hapton {
namespace {

namespace asio = boost::asio;
using asio::ip::udp;
using boost::system::error_code;

constexpr int kBufferBytes = 1 << 20;
// Makes the two directions draw different random numbers from one seed. The number is 2^64 divided by the golden ratio.
constexpr std::uint64_t kOtherDirection = 0x9E3779B97F4A7C15ULL;

enum class Direction : std::uint8_t { to_hub, to_nodes };

struct InFlight {
  std::int64_t due_ns = 0;
  std::uint64_t order = 0;  // breaks ties: first in, first out
  Direction direction = Direction::to_hub;
  udp::endpoint client;
  std::vector<std::byte> bytes;
};

struct LaterFirst {
  bool operator()(const InFlight& a, const InFlight& b) const { return a.due_ns != b.due_ns ? a.due_ns > b.due_ns : a.order > b.order; }
};

// A node, and the socket under which the hub knows it.
struct Client {
  explicit Client(asio::io_context& context) : upstream(context) {}
  udp::endpoint address;
  udp::socket upstream;
  std::int64_t received_ns = 0;
  std::array<std::byte, RelayEndpoint::kMaxBytes + 1> buffer = {};
};

}  // namespace

struct RelayEndpoint::State {
  explicit State(RelaySettings settings_in)
      : settings(std::move(settings_in)),
        injectors{FaultInjector(settings.seed), FaultInjector(settings.seed ^ kOtherDirection)},
        hub(to_endpoint<udp::endpoint>(settings.hub)),
        socket(context),
        timer(context) {}

  error_code open(const udp::endpoint& at);
  void listen();
  void listen_to_hub(const std::shared_ptr<Client>& client);
  Client* find_client(const udp::endpoint& from, std::int64_t now_ns);
  bool make_room(std::int64_t now_ns);
  void enter_phase(std::int64_t now_ns);
  void apply_faults(Direction direction, const udp::endpoint& client, std::span<const std::byte> bytes, std::int64_t now_ns);
  void send(Direction direction, const udp::endpoint& client, std::span<const std::byte> bytes);
  void deliver_due();
  void set_timer();

  RelayCounts& counts(Direction direction) { return direction == Direction::to_hub ? to_hub : to_nodes; }

  RelaySettings settings;
  std::array<FaultInjector, 2> injectors;
  udp::endpoint hub;
  asio::io_context context;
  udp::socket socket;
  asio::steady_timer timer;
  Address local;
  SteadyClock clock;
  std::int64_t start_ns = 0;
  std::size_t phase = static_cast<std::size_t>(-1);
  std::map<udp::endpoint, std::shared_ptr<Client>> clients;
  std::uint64_t clients_seen = 0;
  std::priority_queue<InFlight, std::vector<InFlight>, LaterFirst> queue;
  std::uint64_t order = 0;
  std::int64_t timer_ns = 0;  // 0: not set
  RelayCounts to_hub;
  RelayCounts to_nodes;
  udp::endpoint from;
  std::array<std::byte, kMaxBytes + 1> buffer = {};
};

error_code RelayEndpoint::State::open(const udp::endpoint& at) {
  error_code error;
  socket.open(at.protocol(), error);
  if (error) return error;
  // With a smaller buffer only more datagrams of a flood are lost.
  socket.set_option(asio::socket_base::receive_buffer_size(kBufferBytes), error);
  socket.bind(at, error);
  if (error) return error;
  socket.non_blocking(true, error);
  start_ns = clock.now_ns();
  enter_phase(start_ns);
  return error;
}

void RelayEndpoint::State::listen() {
  socket.async_receive_from(asio::buffer(buffer), from, [this](const error_code& error, std::size_t bytes) {
    if (error == asio::error::operation_aborted) return;
    // Other errors mean that a node is gone: there is nothing to forward, and the relay continues.
    if (!error) {
      const std::int64_t now_ns = clock.now_ns();
      ++to_hub.received;
      if (bytes > kMaxBytes || find_client(from, now_ns) == nullptr) {
        ++to_hub.rejected;
      } else {
        apply_faults(Direction::to_hub, from, std::span(buffer).first(bytes), now_ns);
      }
    }
    listen();
  });
}

void RelayEndpoint::State::listen_to_hub(const std::shared_ptr<Client>& client) {
  client->upstream.async_receive(asio::buffer(client->buffer), [this, client](const error_code& error, std::size_t bytes) {
    if (error == asio::error::operation_aborted || !client->upstream.is_open()) return;
    // Other errors mean that the hub is not there at the moment.
    if (!error) {
      ++to_nodes.received;
      if (bytes > kMaxBytes) {
        ++to_nodes.rejected;
      } else {
        apply_faults(Direction::to_nodes, client->address, std::span(client->buffer).first(bytes), clock.now_ns());
      }
    }
    listen_to_hub(client);
  });
}

bool RelayEndpoint::State::make_room(std::int64_t now_ns) {
  if (clients.size() < kMaxClients) return true;
  const auto idle =
      std::find_if(clients.begin(), clients.end(), [&](const auto& entry) { return now_ns - entry.second->received_ns > kIdleNs; });
  if (idle == clients.end()) return false;
  error_code ignored;
  idle->second->upstream.close(ignored);
  clients.erase(idle);
  return true;
}

Client* RelayEndpoint::State::find_client(const udp::endpoint& node, std::int64_t now_ns) {
  if (const auto known = clients.find(node); known != clients.end()) {
    known->second->received_ns = now_ns;
    return known->second.get();
  }
  if (!make_room(now_ns)) return nullptr;
  auto client = std::make_shared<Client>(context);
  client->address = node;
  client->received_ns = now_ns;
  error_code error;
  client->upstream.open(hub.protocol(), error);
  if (!error) client->upstream.connect(hub, error);
  if (!error) client->upstream.non_blocking(true, error);
  if (error) return nullptr;
  ++clients_seen;
  listen_to_hub(client);
  return clients.emplace(node, std::move(client)).first->second.get();
}

void RelayEndpoint::State::enter_phase(std::int64_t now_ns) {
  const std::size_t now = settings.schedule.find_phase(now_ns - start_ns);
  if (now == phase) return;
  phase = now;
  const bool is_over = now >= settings.schedule.phases.size();
  injectors[0].set(is_over ? LinkFaults() : settings.schedule.phases[now].to_hub);
  injectors[1].set(is_over ? LinkFaults() : settings.schedule.phases[now].to_nodes);
}

void RelayEndpoint::State::apply_faults(Direction direction, const udp::endpoint& client, std::span<const std::byte> bytes,
                                        std::int64_t now_ns) {
  enter_phase(now_ns);
  RelayCounts& count = counts(direction);
  const Fate fate = injectors[static_cast<std::size_t>(direction)].draw(now_ns);
  switch (fate.kind) {
    case Fate::Kind::lost:
      ++count.lost;
      return;
    case Fate::Kind::lost_in_burst:
      ++count.lost_in_burst;
      return;
    case Fate::Kind::partitioned:
      ++count.partitioned;
      return;
    case Fate::Kind::passed:
      break;
  }
  count.held_back += fate.held_back ? 1 : 0;
  count.duplicated += fate.copies > 1 ? 1 : 0;
  count.corrupted += fate.corrupt ? 1 : 0;
  std::array<std::byte, kMaxBytes> corrupted;
  if (fate.corrupt) {
    std::copy(bytes.begin(), bytes.end(), corrupted.begin());
    bytes = std::span(corrupted).first(bytes.size());
    damage_bytes(std::span(corrupted).first(bytes.size()), fate.damage);
  }
  for (std::size_t copy = 0; copy < fate.copies; ++copy) {
    if (fate.due_ns[copy] <= now_ns) {
      send(direction, client, bytes);
    } else if (queue.size() >= kMaxQueued) {
      ++count.overflowed;
    } else {
      queue.push({fate.due_ns[copy], ++order, direction, client, {bytes.begin(), bytes.end()}});
    }
  }
  set_timer();
}

void RelayEndpoint::State::send(Direction direction, const udp::endpoint& client, std::span<const std::byte> bytes) {
  error_code error;
  const auto known = clients.find(client);
  if (known == clients.end()) {
    ++counts(direction).send_failures;
    return;
  }
  // The error of an earlier datagram (no such peer) is returned by the next call and does not concern this one: try again.
  for (int attempt = 0; attempt < 2; ++attempt) {
    if (direction == Direction::to_hub) {
      known->second->upstream.send(asio::buffer(bytes.data(), bytes.size()), 0, error);
    } else {
      socket.send_to(asio::buffer(bytes.data(), bytes.size()), client, 0, error);
    }
    if (error != asio::error::connection_refused) break;
  }
  ++(error ? counts(direction).send_failures : counts(direction).forwarded);
}

void RelayEndpoint::State::deliver_due() {
  const std::int64_t now_ns = clock.now_ns();
  while (!queue.empty() && queue.top().due_ns <= now_ns) {
    const InFlight datagram = queue.top();
    queue.pop();
    send(datagram.direction, datagram.client, datagram.bytes);
  }
  set_timer();
}

void RelayEndpoint::State::set_timer() {
  const std::int64_t wanted_ns = queue.empty() ? 0 : queue.top().due_ns;
  if (wanted_ns == timer_ns) return;
  timer_ns = wanted_ns;
  if (wanted_ns == 0) return;
  timer.expires_at(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(wanted_ns)));
  timer.async_wait([this](const error_code& error) {
    if (error) return;  // the timer was set again meanwhile
    timer_ns = 0;
    deliver_due();
  });
}

RelayEndpoint::RelayEndpoint(std::unique_ptr<State> state) : state_(std::move(state)) {}
RelayEndpoint::~RelayEndpoint() = default;
RelayEndpoint::RelayEndpoint(RelayEndpoint&&) noexcept = default;

Result<RelayEndpoint> RelayEndpoint::open(RelaySettings settings) {
  const auto at = parse_address(settings.listen);
  if (!at) {
    return tl::unexpected(at.error());
  }
  for (const FaultPhase& phase : settings.schedule.phases) {
    for (const LinkFaults* faults : {&phase.to_hub, &phase.to_nodes}) {
      if (const auto checked = check_faults(*faults); !checked) {
        return fail("phase '{}': {}", phase.name, checked.error().what);
      }
    }
  }
  auto made = make_with_context<State>(std::move(settings));
  if (!made) return fail("cannot relay: {}", made.error().what);
  std::unique_ptr<State> state = std::move(*made);
  error_code error = state->open(to_endpoint<udp::endpoint>(*at));
  if (error == asio::error::address_in_use) {
    return fail("cannot listen on UDP {}: another program holds this port; stop it or choose another port", to_string(*at));
  }
  if (error) {
    return fail("cannot listen on UDP {}: {}", to_string(*at), error.message());
  }
  state->local = *at;
  state->local.port = state->socket.local_endpoint(error).port();
  state->listen();
  return RelayEndpoint(std::move(state));
}

void RelayEndpoint::run_for_ns(std::int64_t duration_ns) {
  state_->context.restart();
  state_->context.run_for(std::chrono::nanoseconds(duration_ns));
  state_->enter_phase(state_->clock.now_ns());
}

const Address& RelayEndpoint::local_address() const { return state_->local; }
const RelayCounts& RelayEndpoint::to_hub() const { return state_->to_hub; }
const RelayCounts& RelayEndpoint::to_nodes() const { return state_->to_nodes; }
std::uint64_t RelayEndpoint::clients() const { return state_->clients_seen; }
std::size_t RelayEndpoint::phase() const { return state_->phase; }

}  // namespace hapton
