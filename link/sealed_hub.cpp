#include "link/sealed_hub.h"

#include <algorithm>

#include "link/random_id.h"

namespace hapton {
namespace {

// What one call passes over once its deadline has come, so that a flood of it cannot hold the caller.
constexpr int kMostRefusedPerPoll = 64;

}  // namespace

SealedHub::SealedHub(Endpoint& endpoint, const Clock& clock, const LinkKey& key)
    : endpoint_(endpoint), clock_(clock), handshake_(key), generation_(static_cast<std::uint32_t>(make_random_id())) {}

bool SealedHub::send(const Address& to, std::span<const std::byte> datagram) noexcept {
  Session* const session = find_live(to);
  if (session == nullptr) return false;
  const std::size_t bytes = session->channel.seal(datagram, outgoing_);
  return bytes != 0 && endpoint_.send(to, std::span(outgoing_).first(bytes));
}

Received SealedHub::receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept {
  for (int refused = 0; refused < kMostRefusedPerPoll || clock_.now_ns() < deadline_ns; ++refused) {
    const Received received = endpoint_.receive(incoming_, deadline_ns);
    if (received.bytes == 0) return {};
    const std::size_t bytes = open(std::span(incoming_).first(received.bytes), received.from, into);
    if (bytes != 0) return {.bytes = bytes, .from = received.from};
  }
  return {};
}

// The bytes opened; 0 for what was refused or was a handshake.
std::size_t SealedHub::open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into) noexcept {
  const SealedKind found = classify_sealed(datagram);
  if (found.status != OpenStatus::opened) {
    count(found.status, counts_);
    return 0;
  }
  if (found.kind == seal::Kind::request) {
    hear_request(datagram, from);
    return 0;
  }
  if (found.kind != seal::Kind::data) {
    ++counts_.malformed;  // a hub's own words
    return 0;
  }
  Session& session = sessions_[seal::load<std::uint32_t>(seal::bytes_of(datagram) + seal::kConnectionAt) % kPlaces];
  if (session.state == State::free || session.address != from) {
    ++counts_.unknown_session;
    return 0;
  }
  std::size_t bytes = 0;
  count(session.channel.open(datagram, into, bytes), counts_);
  if (bytes == 0) return 0;
  session.last_heard_ns = clock_.now_ns();
  if (session.state == State::candidate) promote(session);
  return bytes;
}

void SealedHub::promote(Session& session) noexcept {
  for (Session& other : sessions_) {
    if (&other != &session && other.state != State::free && other.address == session.address) other = Session();
  }
  session.state = State::live;
  ++counts_.handshakes;
}

void SealedHub::hear_request(std::span<const std::byte> request, const Address& from) noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  const seal::Nonce client_nonce = HubHandshake::nonce_of(request);
  switch (handshake_.judge(request, from, now_ns)) {
    case HubHandshake::Verdict::stranger:
      ++counts_.wrong_key;
      return;
    case HubHandshake::Verdict::wants_cookie: {
      const std::size_t bytes = handshake_.write_retry(client_nonce, from, now_ns, outgoing_);
      endpoint_.send(from, std::span(outgoing_).first(bytes));
      return;
    }
    case HubHandshake::Verdict::shows_cookie:
      return agree(client_nonce, from, now_ns);
  }
}

void SealedHub::agree(const seal::Nonce& client_nonce, const Address& from, std::int64_t now_ns) noexcept {
  Session* session = find_agreed(client_nonce, from);
  if (session == nullptr) {
    session = find_place(now_ns);
    if (session == nullptr) {
      ++counts_.no_place;
      return;
    }
    const auto place = static_cast<std::uint32_t>(session - sessions_.data());
    const std::uint32_t connection = ++generation_ * static_cast<std::uint32_t>(kPlaces) + place;
    session->state = State::candidate;
    session->address = from;
    session->last_heard_ns = now_ns;
    session->client_nonce = client_nonce;
    session->channel = handshake_.agree(client_nonce, connection, session->answer);
  }
  endpoint_.send(from, session->answer);
}

SealedHub::Session* SealedHub::find_live(const Address& address) noexcept {
  const auto is_it = [&](const Session& session) { return session.state == State::live && session.address == address; };
  if (is_it(sessions_[last_place_])) return &sessions_[last_place_];
  const auto found = std::find_if(sessions_.begin(), sessions_.end(), is_it);
  if (found == sessions_.end()) return nullptr;
  last_place_ = static_cast<std::size_t>(found - sessions_.begin());
  return &*found;
}

SealedHub::Session* SealedHub::find_agreed(const seal::Nonce& client_nonce, const Address& address) noexcept {
  const auto found = std::find_if(sessions_.begin(), sessions_.end(), [&](const Session& session) {
    return session.state != State::free && session.address == address && session.client_nonce == client_nonce;
  });
  return found == sessions_.end() ? nullptr : &*found;
}

// A free place, else that of the oldest candidate when there are many, else of who has been silent long; null when there is none.
SealedHub::Session* SealedHub::find_place(std::int64_t now_ns) noexcept {
  Session* free_place = nullptr;
  Session* oldest_candidate = nullptr;
  Session* quietest = nullptr;
  std::size_t candidates = 0;
  const auto older = [](const Session& session, const Session* than) {
    return than == nullptr || session.last_heard_ns < than->last_heard_ns;
  };
  for (Session& session : sessions_) {
    if (session.state == State::free) {
      free_place = free_place == nullptr ? &session : free_place;
    } else if (session.state == State::candidate) {
      ++candidates;
      if (older(session, oldest_candidate)) oldest_candidate = &session;
    } else if (now_ns - session.last_heard_ns > kIdleNs && older(session, quietest)) {
      quietest = &session;
    }
  }
  if (candidates >= kCandidates) return oldest_candidate;
  if (free_place != nullptr) return free_place;
  return quietest != nullptr ? quietest : oldest_candidate;
}

}  // namespace hapton
