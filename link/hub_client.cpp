#include "link/hub_client.h"

#include <algorithm>

#include "link/random_id.h"

namespace hapton {
namespace {

// Invalid datagrams that one call skips after its deadline, so that a flood of them cannot hold up the caller.
constexpr int kMaxRejectedPerPoll = 64;

}  // namespace

HubClient::HubClient(Endpoint& endpoint, const Clock& clock, NodeRole role, const Address& hub, std::uint64_t sender_id)
    : endpoint_(endpoint), clock_(clock), role_(role), hub_(hub), sender_(sender_id != 0 ? sender_id : make_random_id()) {}

HubClient::~HubClient() { leave(); }

void HubClient::leave() noexcept {
  if (state_ != JoinState::joined) return;
  transmit(Bye{}, clock_.now_ns());
  state_ = JoinState::joining;
}

JoinState HubClient::state() const noexcept {
  const bool is_hub_silent = state_ != JoinState::joining && clock_.now_ns() - last_received_ns_ > kHubTimeoutNs;
  return is_hub_silent ? JoinState::joining : state_;
}

bool HubClient::send(const Message& message) noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  say_hello_if_due(now_ns);
  if (state_ != JoinState::joined || !transmit(message, now_ns)) {
    ++counts_.send_failures;
    return false;
  }
  return true;
}

bool HubClient::transmit(const Message& message, std::int64_t now_ns) noexcept {
  outgoing_.header = {.session = session_, .sender = sender_, .sequence = ++sequence_, .send_time_ns = now_ns};
  outgoing_.message = message;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  const std::size_t size = codec_.encode(outgoing_, bytes);
  if (size == 0 || !endpoint_.send(hub_, std::span(bytes).first(size))) {
    return false;
  }
  ++counts_.sent;
  return true;
}

void HubClient::say_hello_if_due(std::int64_t now_ns) noexcept {
  if (now_ns >= next_hello_ns_) {
    next_hello_ns_ = now_ns + kHelloPeriodNs;
    transmit(Hello{role_}, now_ns);
  }
}

bool HubClient::receive(Datagram& out, std::int64_t deadline_ns) noexcept {
  std::int64_t now_ns = clock_.now_ns();
  for (int rejected = 0; rejected < kMaxRejectedPerPoll || now_ns < deadline_ns; now_ns = clock_.now_ns()) {
    say_hello_if_due(now_ns);
    const Received received = endpoint_.receive(buffer_, std::min(deadline_ns, next_hello_ns_));
    if (received.bytes == 0) {
      if (clock_.now_ns() >= deadline_ns) {
        return false;
      }
      continue;
    }
    if (received.from != hub_) {
      ++counts_.foreign;
      ++rejected;
      continue;
    }
    const DecodeStatus status = codec_.decode(std::span(buffer_).first(received.bytes), out);
    if (status != DecodeStatus::ok) {
      ++counts_.undecodable;
      counts_.wrong_version += status == DecodeStatus::wrong_version ? 1 : 0;
      ++rejected;
      continue;
    }
    if (accept(out, clock_.now_ns())) {
      return true;
    }
    ++rejected;
  }
  return false;
}

bool HubClient::accept(const Datagram& datagram, std::int64_t now_ns) noexcept {
  const Header& header = datagram.header;
  if (const auto* welcome = std::get_if<Welcome>(&datagram.message)) {
    accept_welcome(header, *welcome, now_ns);
    return false;
  }
  if (state_ != JoinState::joined || header.session != session_) {
    ++counts_.other_session;
    return false;
  }
  const Arrival arrival = tracker_.track(header.sender, header.sequence);
  if (arrival == Arrival::duplicate || arrival == Arrival::stale) {
    return false;
  }
  last_received_ns_ = now_ns;
  if (std::holds_alternative<Bye>(datagram.message)) {
    state_ = JoinState::joining;
    has_hub_left_ = true;
    return false;
  }
  last_arrival_ = order_.note(tracker_, arrival, datagram.message, header.sequence);
  receive_time_ns_ = now_ns;
  ++counts_.received;
  return true;
}

void HubClient::accept_welcome(const Header& header, const Welcome& welcome, std::int64_t now_ns) noexcept {
  if (header.session == 0 || header.session == retired_session_) {
    ++counts_.other_session;  // a late datagram from before the hub's restart
    return;
  }
  const bool was_joined = state() == JoinState::joined && header.session == session_;
  if (was_joined && !welcome.accepted && header.send_time_ns < accepted_at_ns_) return;  // sent before the welcome that accepted this node
  if (header.session != session_) {
    retired_session_ = session_ != 0 ? session_ : retired_session_;
    session_ = header.session;
  }
  last_received_ns_ = now_ns;
  servo_rate_hz_ = welcome.servo_rate_hz;
  if (!welcome.accepted) {
    state_ = JoinState::rejected;
    return;
  }
  tracker_.track(header.sender, header.sequence, !was_joined);
  has_hub_left_ = false;
  accepted_at_ns_ = was_joined ? std::max(accepted_at_ns_, header.send_time_ns) : header.send_time_ns;
  state_ = JoinState::joined;
  counts_.joins += was_joined ? 0 : 1;
}

}  // namespace hapton
