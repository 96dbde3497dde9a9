#include "link/sealed_client.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace hapton {
namespace {

// Rejected datagrams that one call skips after its deadline, so that a flood of them cannot hold up the caller.
constexpr int kMaxRejectedPerPoll = 64;
// While the worker thread is at work the wait is cut into pieces of this length.
constexpr std::int64_t kWorkerPollNs = kNanosecondsPerMillisecond / 2;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

}  // namespace

SealedClient::SealedClient(Endpoint& endpoint, const Clock& clock, const RoleKey& key, const Address& hub, const Options& options)
    : endpoint_(endpoint), clock_(clock), hub_(hub), options_(options), handshake_(key, options.host, options.worker) {}

SealCounts SealedClient::seal_counts() const noexcept {
  SealCounts counts = counts_;
  counts.oversized = endpoint_.socket_counts().oversized;
  return counts;
}

bool SealedClient::send(const Address& to, std::span<const std::byte> datagram) noexcept {
  if (to != hub_ || datagram.size() > seal::kMaxPayloadBytes) return false;
  if (handshake_.is_pending() || !channel_.is_open()) {
    const std::int64_t now_ns = clock_.now_ns();
    request_if_due(now_ns);
    const bool is_held = !channel_.is_open() || is_hub_silent(now_ns);
    if (is_held) {
      std::copy(datagram.begin(), datagram.end(), held_.begin());
      held_bytes_ = datagram.size();
    }
    take_finished();
    if (is_held && held_bytes_ == 0) return was_held_sent_;  // in the session that was just agreed on
  }
  return !channel_.is_open() || transmit(datagram);
}

bool SealedClient::transmit(std::span<const std::byte> datagram) noexcept {
  const std::size_t bytes = channel_.seal(datagram, outgoing_);
  return bytes != 0 && endpoint_.send(hub_, std::span(outgoing_).first(bytes));
}

Received SealedClient::receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept {
  std::int64_t now_ns = clock_.now_ns();
  for (int rejected = 0; rejected < kMaxRejectedPerPoll || now_ns < deadline_ns; now_ns = clock_.now_ns()) {
    request_if_due(now_ns);
    take_finished();
    const Received received = endpoint_.receive(incoming_, std::min(deadline_ns, next_due_ns(now_ns)));
    if (received.bytes == 0) {
      now_ns = clock_.now_ns();
      request_if_silent(now_ns);
      if (now_ns >= deadline_ns) return {};
      continue;
    }
    const std::size_t bytes = open(std::span(incoming_).first(received.bytes), received.from, into);
    if (bytes != 0) return {.bytes = bytes, .from = received.from};
    ++rejected;
  }
  // In a flood there is always something to receive, so the loop does not get to its own check.
  request_if_silent(clock_.now_ns());
  return {};
}

std::int64_t SealedClient::next_due_ns(std::int64_t now_ns) const noexcept {
  const std::int64_t poll_ns = handshake_.is_working() ? now_ns + kWorkerPollNs : kNever;
  return std::min(poll_ns, handshake_.is_pending() ? next_request_ns_ : std::min(rekey_ns_, last_received_ns_ + timeout_ns_));
}

bool SealedClient::is_rekey_due(std::int64_t now_ns) const noexcept {
  return channel_.is_open() && (now_ns >= rekey_ns_ || channel_.sealed() >= options_.rekey_after);
}

void SealedClient::request_if_due(std::int64_t now_ns) noexcept {
  if (has_received_) {
    has_received_ = false;
    last_received_ns_ = now_ns;
  }
  if (previous_.is_open() && previous_ends_ns_ != 0 && now_ns >= previous_ends_ns_) previous_ = SealedChannel();
  if (!handshake_.is_pending() && (!channel_.is_open() || is_rekey_due(now_ns))) return begin(now_ns);
  if (!handshake_.is_pending() || now_ns < next_request_ns_) return;
  next_request_ns_ = now_ns + (is_hub_silent(now_ns) || !channel_.is_open() ? kRequestPeriodNs : kRekeyRequestPeriodNs);
  may_retry_ = true;
  request(now_ns);
}

// Called only if nothing waits to be received, or after many rejections: to a node that was busy for long, the hub only seems silent.
void SealedClient::request_if_silent(std::int64_t now_ns) noexcept {
  if (!is_hub_silent(now_ns)) return;
  if (!handshake_.is_pending()) return begin(now_ns);
  // A rekeying that a timeout interrupts continues at the request rate of a search for the hub.
  next_request_ns_ = std::min(next_request_ns_, now_ns + kRequestPeriodNs);
}

void SealedClient::begin(std::int64_t now_ns) noexcept {
  handshake_.begin();
  next_request_ns_ = now_ns;
  request_if_due(now_ns);
}

void SealedClient::request(std::int64_t now_ns) noexcept {
  handshake_.start_request(now_ns);
  take_finished();
}

void SealedClient::take_finished() noexcept {
  if (!handshake_.is_working()) return;
  std::array<std::byte, seal::kRequestBytes> request;
  while (true) {
    switch (handshake_.poll(request)) {
      case ClientHandshake::Finished::nothing:
        return;
      case ClientHandshake::Finished::request:
        endpoint_.send(hub_, request);
        break;
      case ClientHandshake::Finished::agreement:
        change_over();
        break;
    }
  }
}

void SealedClient::change_over() noexcept {
  ++counts_.handshakes;
  previous_ = std::move(channel_);
  previous_ends_ns_ = 0;  // set when the hub uses the new channel, too
  channel_ = handshake_.take_channel();
  last_received_ns_ = clock_.now_ns();
  timeout_ns_ = kPeerTimeoutNs + std::clamp<std::int64_t>(last_received_ns_ - handshake_.replied_request_ns(), 0, kMaxTripNs);
  rekey_ns_ = last_received_ns_ + options_.rekey_every_ns;
  was_held_sent_ = held_bytes_ != 0 && transmit(std::span(held_).first(held_bytes_));
  held_bytes_ = 0;
}

// The size of the opened data; 0 if rejected or part of a handshake.
std::size_t SealedClient::open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into) noexcept {
  if (from != hub_) {
    ++counts_.unknown_session;
    return 0;
  }
  const SealedKind sealed = classify_sealed(datagram);
  if (sealed.status == OpenStatus::opened && sealed.kind != seal::Kind::data) {
    receive_handshake(sealed.kind, datagram);
    return 0;
  }
  std::size_t bytes = 0;
  OpenStatus status = channel_.open(datagram, into, bytes);
  if (status == OpenStatus::opened) {
    if (previous_.is_open() && previous_ends_ns_ == 0) previous_ends_ns_ = clock_.now_ns() + kOverlapNs;
  } else if (status == OpenStatus::unknown_session && previous_.is_open()) {
    status = previous_.open(datagram, into, bytes);
  }
  count(status, counts_);
  has_received_ = has_received_ || bytes != 0;
  return bytes;
}

void SealedClient::receive_handshake(seal::Kind kind, std::span<const std::byte> datagram) noexcept {
  if (!handshake_.is_pending()) return;  // a late reply to an earlier request is not a fault
  const bool is_valid =
      (kind == seal::Kind::retry && handshake_.read_retry(datagram)) || (kind == seal::Kind::reply && handshake_.read_reply(datagram));
  counts_.wrong_key += is_valid ? 0 : 1;
  if (!is_valid) return;
  if (kind == seal::Kind::retry && std::exchange(may_retry_, false)) request(clock_.now_ns());
  take_finished();
}

}  // namespace hapton
