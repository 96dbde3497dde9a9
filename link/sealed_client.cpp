#include "link/sealed_client.h"

#include <algorithm>
#include <utility>

namespace hapton {
namespace {

// What one call passes over once its deadline has come, so that a flood of it cannot hold the caller.
constexpr int kMostRefusedPerPoll = 64;

}  // namespace

SealedClient::SealedClient(Endpoint& endpoint, const Clock& clock, const LinkKey& key, const Address& hub)
    : endpoint_(endpoint), clock_(clock), hub_(hub), handshake_(key) {}

bool SealedClient::send(const Address& to, std::span<const std::byte> datagram) noexcept {
  if (to != hub_ || datagram.size() > seal::kMaxPayloadBytes) return false;
  if (handshake_.is_pending() || !channel_.is_open()) {
    std::copy(datagram.begin(), datagram.end(), held_.begin());
    held_bytes_ = datagram.size();
    ask_if_due(clock_.now_ns());
  }
  return !channel_.is_open() || transmit(datagram);
}

bool SealedClient::transmit(std::span<const std::byte> datagram) noexcept {
  const std::size_t bytes = channel_.seal(datagram, outgoing_);
  return bytes != 0 && endpoint_.send(hub_, std::span(outgoing_).first(bytes));
}

Received SealedClient::receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept {
  std::int64_t now_ns = clock_.now_ns();
  for (int refused = 0; refused < kMostRefusedPerPoll || now_ns < deadline_ns; now_ns = clock_.now_ns()) {
    ask_if_due(now_ns);
    const Received received = endpoint_.receive(incoming_, std::min(deadline_ns, next_due_ns()));
    if (received.bytes == 0) {
      now_ns = clock_.now_ns();
      ask_if_silent(now_ns);
      if (now_ns >= deadline_ns) return {};
      continue;
    }
    const std::size_t bytes = open(std::span(incoming_).first(received.bytes), received.from, into);
    if (bytes != 0) return {.bytes = bytes, .from = received.from};
    ++refused;
  }
  return {};
}

std::int64_t SealedClient::next_due_ns() const noexcept { return handshake_.is_pending() ? next_request_ns_ : last_heard_ns_ + kSilenceNs; }

void SealedClient::ask_if_due(std::int64_t now_ns) noexcept {
  if (has_heard_) {
    has_heard_ = false;
    last_heard_ns_ = now_ns;
  }
  if (!channel_.is_open() && !handshake_.is_pending()) return begin(now_ns);
  if (!handshake_.is_pending() || now_ns < next_request_ns_) return;
  next_request_ns_ = now_ns + kRequestPeriodNs;
  may_retry_ = true;
  ask();
}

// Once nothing waits to be received: a node that was busy for long has not been left in silence.
void SealedClient::ask_if_silent(std::int64_t now_ns) noexcept {
  if (!handshake_.is_pending() && now_ns - last_heard_ns_ >= kSilenceNs) begin(now_ns);
}

void SealedClient::begin(std::int64_t now_ns) noexcept {
  handshake_.begin();
  next_request_ns_ = now_ns;
  ask_if_due(now_ns);
}

void SealedClient::ask() noexcept {
  const std::size_t bytes = handshake_.write_request(outgoing_);
  endpoint_.send(hub_, std::span(outgoing_).first(bytes));
}

// The bytes opened; 0 for what was refused or was the handshake's.
std::size_t SealedClient::open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into) noexcept {
  if (from != hub_) {
    ++counts_.unknown_session;
    return 0;
  }
  const SealedKind found = classify_sealed(datagram);
  if (found.status == OpenStatus::opened && found.kind != seal::Kind::data) {
    hear_handshake(found.kind, datagram);
    return 0;
  }
  std::size_t bytes = 0;
  OpenStatus status = channel_.open(datagram, into, bytes);
  if (status == OpenStatus::opened) {
    if (previous_.is_open()) previous_ = SealedChannel();
  } else if (status == OpenStatus::unknown_session && previous_.is_open()) {
    status = previous_.open(datagram, into, bytes);
  }
  count(status, counts_);
  has_heard_ = has_heard_ || bytes != 0;
  return bytes;
}

void SealedClient::hear_handshake(seal::Kind kind, std::span<const std::byte> datagram) noexcept {
  switch (handshake_.read(kind, datagram)) {
    case ClientHandshake::Heard::nothing:
      // A late answer to an earlier request is nobody's fault.
      counts_.wrong_key += handshake_.is_pending() ? 1 : 0;
      return;
    case ClientHandshake::Heard::cookie:
      if (may_retry_) ask();
      may_retry_ = false;
      return;
    case ClientHandshake::Heard::agreement:
      ++counts_.handshakes;
      previous_ = std::move(channel_);
      channel_ = handshake_.take_channel();
      has_heard_ = true;
      if (held_bytes_ != 0) transmit(std::span(held_).first(held_bytes_));
      held_bytes_ = 0;
      return;
  }
}

}  // namespace hapton
