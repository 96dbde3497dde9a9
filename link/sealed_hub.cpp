#include "link/sealed_hub.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "link/random_id.h"

namespace hapton {
namespace {

// Rejected datagrams that one call skips after its deadline, so that a flood of them cannot hold up the caller.
constexpr int kMaxRejectedPerPoll = 64;

Rejection rejection_of(OpenStatus status) noexcept {
  switch (status) {
    case OpenStatus::wrong_version:
      return Rejection::wrong_version;
    case OpenStatus::unknown_session:
      return Rejection::unknown_session;
    case OpenStatus::replayed:
      return Rejection::replayed;
    case OpenStatus::forged:
      return Rejection::forged;
    case OpenStatus::opened:
    case OpenStatus::malformed:
      break;
  }
  return Rejection::malformed;
}

std::uint64_t& counter_of(Rejection rejection, SealCounts& counts) noexcept {
  switch (rejection) {
    case Rejection::malformed:
      return counts.malformed;
    case Rejection::wrong_version:
      return counts.wrong_version;
    case Rejection::wrong_key:
      return counts.wrong_key;
    case Rejection::replayed_handshake:
      return counts.replayed_handshakes;
    case Rejection::too_many_handshakes:
      return counts.too_many_handshakes;
    case Rejection::no_slot:
      return counts.no_slot;
    case Rejection::unknown_session:
      return counts.unknown_session;
    case Rejection::replayed:
      return counts.replayed;
    case Rejection::forged:
      return counts.forged;
    case Rejection::oversized:
      return counts.oversized;
  }
  return counts.malformed;
}

constexpr std::size_t index_of(KeyRole role) noexcept { return static_cast<std::size_t>(role) - kFirstKeyRole; }

std::array<SourceLimit, kNodeKeyRoles> make_limits() {
  const auto make = [] { return SourceLimit(SealedHub::kHandshakeRates, make_random_id()); };
  return {make(), make(), make(), make()};
}

static_assert(std::accumulate(SealedHub::kRoleSlots.begin(), SealedHub::kRoleSlots.end(), std::size_t{0}) == SealedHub::kSlots);

}  // namespace

SealedHub::SealedHub(Endpoint& endpoint, const Clock& clock, const LinkKey& master, AgreementWorker::Where worker)
    : endpoint_(endpoint),
      clock_(clock),
      handshake_(master, worker),
      retry_limits_(make_limits()),
      agreement_limits_(make_limits()),
      generation_(static_cast<std::uint32_t>(make_random_id())) {}

SealCounts SealedHub::seal_counts() const noexcept {
  SealCounts counts = counts_;
  counts.oversized = endpoint_.socket_counts().oversized;
  return counts;
}

void SealedHub::reject(Rejection rejection, const Address& from) noexcept {
  ++counter_of(rejection, counts_);
  rejection_monitor_.note(rejection, from);
}

// The worst flood of rejected datagrams, counting those that the socket rejected or filtered.
std::optional<Flood> SealedHub::take_flood(std::int64_t now_ns) noexcept {
  const SocketCounts socket = endpoint_.socket_counts();
  const std::uint64_t oversized = socket.oversized - oversized_noted_;
  if (oversized != 0) rejection_monitor_.note(Rejection::oversized, socket.last_oversized, oversized);
  rejection_monitor_.note_filtered(socket.filtered - filtered_noted_);
  oversized_noted_ = socket.oversized;
  filtered_noted_ = socket.filtered;
  return rejection_monitor_.take(now_ns);
}

bool SealedHub::send(const Address& to, std::span<const std::byte> datagram) noexcept {
  take_agreements();
  Session* const session = find_live(to);
  if (session == nullptr) return false;
  const std::size_t bytes = session->channel.seal(datagram, outgoing_);
  return bytes != 0 && endpoint_.send(to, std::span(outgoing_).first(bytes));
}

Received SealedHub::receive(std::span<std::byte> into, std::int64_t deadline_ns) noexcept {
  for (int rejected = 0; rejected < kMaxRejectedPerPoll || clock_.now_ns() < deadline_ns; ++rejected) {
    take_agreements();
    const Received received = endpoint_.receive(incoming_, deadline_ns);
    if (received.bytes == 0) return {};
    Received opened{.bytes = 0, .from = received.from};
    opened.bytes = open(std::span(incoming_).first(received.bytes), received.from, into, opened.role);
    if (opened.bytes != 0) return opened;
  }
  return {};
}

// The size of the opened data; 0 if rejected or part of a handshake.
std::size_t SealedHub::open(std::span<const std::byte> datagram, const Address& from, std::span<std::byte> into, KeyRole& role) noexcept {
  const SealedKind sealed = classify_sealed(datagram);
  if (sealed.status != OpenStatus::opened) {
    reject(rejection_of(sealed.status), from);
    return 0;
  }
  if (sealed.kind == seal::Kind::request) {
    receive_request(datagram, from);
    take_agreements();
    return 0;
  }
  if (sealed.kind != seal::Kind::data) {
    reject(Rejection::malformed, from);  // only a hub sends these
    return 0;
  }
  Session& session = sessions_[seal::load<std::uint32_t>(seal::bytes_of(datagram) + seal::kConnectionAt) % kSlots];
  if (session.state == State::free || session.state == State::agreeing || session.address != from) {
    reject(Rejection::unknown_session, from);
    return 0;
  }
  const std::int64_t now_ns = clock_.now_ns();
  if (session.state == State::retiring && now_ns >= session.ends_ns) {
    session = Session();
    reject(Rejection::unknown_session, from);
    return 0;
  }
  std::size_t bytes = 0;
  const OpenStatus status = session.channel.open(datagram, into, bytes);
  if (bytes == 0) {
    reject(rejection_of(status), from);
    return 0;
  }
  ++counts_.opened;
  session.last_received_ns = now_ns;
  role = session.role;
  if (session.state == State::candidate) promote(session);
  return bytes;
}

void SealedHub::promote(Session& session) noexcept {
  for (Session& other : sessions_) {
    if (&other == &session || other.state == State::free || other.address != session.address) continue;
    if (other.state == State::live && other.role == session.role) {
      other.state = State::retiring;
      other.ends_ns = session.last_received_ns + kOverlapNs;
    } else {
      other = Session();  // only the session just replaced still receives for a while
    }
  }
  session.state = State::live;
  ++counts_.handshakes;
}

void SealedHub::receive_request(std::span<const std::byte> request, const Address& from) noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  switch (handshake_.check_request(request, from, now_ns)) {
    case HubHandshake::Verdict::malformed:
      return reject(Rejection::malformed, from);
    case HubHandshake::Verdict::wrong_key:
      return reject(Rejection::wrong_key, from);
    case HubHandshake::Verdict::replayed:
      return reject(Rejection::replayed_handshake, from);
    case HubHandshake::Verdict::wants_cookie:
      return retry(request, from, now_ns);
    case HubHandshake::Verdict::shows_cookie:
      return agree(request, from, now_ns);
  }
}

void SealedHub::retry(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) noexcept {
  if (!retry_limits_[index_of(HubHandshake::role_of(request))].take(from, now_ns)) return reject(Rejection::too_many_handshakes, from);
  const std::size_t bytes = handshake_.write_retry(request, from, now_ns, outgoing_);
  counts_.retries += endpoint_.send(from, std::span(outgoing_).first(bytes)) ? 1 : 0;
}

void SealedHub::agree(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) noexcept {
  const KeyRole role = HubHandshake::role_of(request);
  if (had_reply_lately(from, role, now_ns)) {
    ++counts_.repeats;
    return;
  }
  if (!agreement_limits_[index_of(role)].take(from, now_ns)) return reject(Rejection::too_many_handshakes, from);
  if (is_taken_by_another_role(from, role, now_ns)) return reject(Rejection::no_slot, from);
  Session* const session = find_slot(slots_of(role, sessions_), now_ns);
  if (session == nullptr) return reject(Rejection::no_slot, from);
  const auto slot = static_cast<std::uint32_t>(session - sessions_.data());
  const std::uint32_t connection = ++generation_ * static_cast<std::uint32_t>(kSlots) + slot;
  if (!handshake_.agree(request, connection)) return reject(Rejection::too_many_handshakes, from);
  *session = Session();
  session->state = State::agreeing;
  session->role = role;
  session->address = from;
  session->connection = connection;
  session->last_received_ns = now_ns;
}

void SealedHub::take_agreements() noexcept {
  if (!handshake_.is_working()) return;
  for (HubHandshake::Agreement agreed; handshake_.poll(agreed);) {
    Session& session = sessions_[agreed.connection % kSlots];
    // Its slot may have been reused by now.
    if (session.state != State::agreeing || session.connection != agreed.connection) continue;
    if (!agreed.is_valid) {
      reject(Rejection::wrong_key, session.address);
      session = Session();
      continue;
    }
    session.state = State::candidate;
    session.channel = std::move(agreed.channel);
    endpoint_.expect(session.address, session.connection);
    endpoint_.send(session.address, agreed.reply);
  }
}

SealedHub::Session* SealedHub::find_live(const Address& address) noexcept {
  const auto is_match = [&](const Session& session) { return session.state == State::live && session.address == address; };
  std::uint8_t& hint = hints_[address.port % hints_.size()];
  if (is_match(sessions_[hint])) return &sessions_[hint];
  const auto found = std::find_if(sessions_.begin(), sessions_.end(), is_match);
  if (found == sessions_.end()) return nullptr;
  hint = static_cast<std::uint8_t>(found - sessions_.begin());
  return &*found;
}

std::span<SealedHub::Session> SealedHub::slots_of(KeyRole role, std::array<Session, kSlots>& sessions) noexcept {
  const auto before = kRoleSlots.begin() + static_cast<std::ptrdiff_t>(index_of(role));
  return std::span(sessions).subspan(std::accumulate(kRoleSlots.begin(), before, std::size_t{0}), *before);
}

// With many candidates the oldest one's slot; otherwise a free one, that of a peer silent for long, or the oldest candidate's; else null.
SealedHub::Session* SealedHub::find_slot(std::span<Session> slots, std::int64_t now_ns) noexcept {
  Session* free_slot = nullptr;
  Session* oldest_candidate = nullptr;
  Session* longest_silent = nullptr;
  std::size_t candidates = 0;
  const auto older = [](const Session& session, const Session* than) {
    return than == nullptr || session.last_received_ns < than->last_received_ns;
  };
  for (Session& session : slots) {
    const bool is_over = session.state == State::retiring && now_ns >= session.ends_ns;
    if (session.state == State::free || is_over) {
      free_slot = free_slot == nullptr ? &session : free_slot;
    } else if (session.state == State::candidate || session.state == State::agreeing) {
      ++candidates;
      if (older(session, oldest_candidate)) oldest_candidate = &session;
    } else if (session.state == State::live && now_ns - session.last_received_ns > kIdleNs && older(session, longest_silent)) {
      longest_silent = &session;
    }
  }
  if (candidates >= max_candidates(slots)) return oldest_candidate;
  if (free_slot != nullptr) return free_slot;
  return longest_silent != nullptr ? longest_silent : oldest_candidate;
}

// The last reply to this address may still be under way. If all slots for candidates are taken, an address that has a candidate gets no
// further one, so that far nodes do not displace each other's candidates; candidates older than any round trip do not count.
bool SealedHub::had_reply_lately(const Address& address, KeyRole role, std::int64_t now_ns) noexcept {
  std::int64_t wait_ns = 0;
  std::int64_t newest_ns = 0;
  std::size_t recent_candidates = 0;
  const std::span<Session> slots = slots_of(role, sessions_);
  for (const Session& session : slots) {
    const bool is_unused = session.state == State::candidate || session.state == State::agreeing;
    if (!is_unused || now_ns - session.last_received_ns >= kReplyLivesNs) continue;
    ++recent_candidates;
    if (session.address != address) continue;
    wait_ns = wait_ns == 0 ? kReplyEveryNs : std::min(2 * wait_ns, kMaxReplyEveryNs);
    newest_ns = std::max(newest_ns, session.last_received_ns);
  }
  return wait_ns != 0 && (now_ns - newest_ns < wait_ns || recent_candidates >= max_candidates(slots));
}

// An address belongs to one program. A holder of another role's key who can forge that address must not end that program's session.
bool SealedHub::is_taken_by_another_role(const Address& address, KeyRole role, std::int64_t now_ns) const noexcept {
  return std::any_of(sessions_.begin(), sessions_.end(), [&](const Session& session) {
    return session.state == State::live && session.address == address && session.role != role &&
           now_ns - session.last_received_ns <= kIdleNs;
  });
}

}  // namespace hapton
