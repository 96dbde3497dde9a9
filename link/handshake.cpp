#include "link/handshake.h"

#include <sodium.h>

#include <algorithm>

namespace hapton {

using namespace seal;

namespace {

std::span<const std::uint8_t> signed_part(const std::uint8_t* in, std::size_t tag_at) { return {in, tag_at}; }

void sign(const Secret& key, std::uint8_t* out, std::size_t tag_at) {
  const Tag tag = compute_tag(key, signed_part(out, tag_at));
  std::copy(tag.begin(), tag.end(), out + tag_at);
}

bool is_signed(const Secret& key, const std::uint8_t* in, std::size_t tag_at) {
  return is_tag(compute_tag(key, signed_part(in, tag_at)), in + tag_at);
}

// Hides the host id, so that an eavesdropper cannot find out which nodes run on one host, except nodes of the same role.
std::uint64_t hide_host(std::uint64_t host, const Secret& key) {
  std::array<std::uint8_t, 1 + sizeof host> text = {'h'};
  store(host, text.data() + 1);
  return load<std::uint64_t>(compute_tag(key, text).data());
}

}  // namespace

ClientHandshake::ClientHandshake(const RoleKey& key, std::uint64_t host, AgreementWorker::Where where)
    : role_(key.role()),
      handshake_key_(derive_handshake_key(key)),
      psk_(derive_psk(key)),
      host_(hide_host(host, handshake_key_)),
      worker_(where) {}

ClientHandshake::~ClientHandshake() {
  wipe(handshake_key_);
  wipe(psk_);
}

void ClientHandshake::begin() noexcept {
  forget_attempts();
  cookie_ = {};
  ++handshake_number_;
  is_pending_ = true;
}

void ClientHandshake::forget_attempts() noexcept { attempts_ = {}; }

void ClientHandshake::write_prologue(std::int64_t timestamp_ns, std::uint8_t* into) const noexcept {
  write_lead(Kind::request, into);
  store(std::uint32_t{static_cast<std::uint8_t>(role_)}, into + kRoleAt);
  store(host_, into + kHostAt);
  store(timestamp_ns, into + kRequestTimestampAt);
}

bool ClientHandshake::start_request(std::int64_t now_ns) noexcept {
  AgreementTask task;
  task.kind = AgreementTask::Kind::make_request;
  task.number = handshake_number_;
  task.timestamp_ns = std::max(now_ns, last_timestamp_ns_ + 1);
  task.psk = psk_;
  write_prologue(task.timestamp_ns, task.prologue.data());
  if (!worker_.submit(task)) return false;
  last_timestamp_ns_ = task.timestamp_ns;
  return true;
}

ClientHandshake::Finished ClientHandshake::poll(std::span<std::byte> into) noexcept {
  for (AgreementTask task; worker_.take(task);) {
    if (task.number != handshake_number_ || !is_pending_ || !task.is_valid) continue;
    if (task.kind == AgreementTask::Kind::make_request) {
      write_request(task, bytes_of(into));
      return Finished::request;
    }
    channel_ = SealedChannel(task.keys, task.connection, SealedChannel::Side::client);
    forget_attempts();
    is_pending_ = false;
    return Finished::agreement;
  }
  return Finished::nothing;
}

void ClientHandshake::write_request(const AgreementTask& task, std::uint8_t* out) noexcept {
  attempts_[next_attempt_] = {task.timestamp_ns, true, task.state};
  next_attempt_ = (next_attempt_ + 1) % kAttempts;
  std::copy(task.prologue.begin(), task.prologue.end(), out);
  std::copy(task.first.begin(), task.first.end(), out + kFirstAt);
  std::copy(cookie_.begin(), cookie_.end(), out + kRequestCookieAt);
  sign(handshake_key_, out, kRequestTagAt);
}

ClientHandshake::Attempt* ClientHandshake::find_attempt(std::int64_t timestamp_ns) noexcept {
  const auto is_match = [&](const Attempt& attempt) { return attempt.is_open && attempt.timestamp_ns == timestamp_ns; };
  const auto found = std::find_if(attempts_.begin(), attempts_.end(), is_match);
  return found == attempts_.end() ? nullptr : &*found;
}

bool ClientHandshake::read_retry(std::span<const std::byte> retry) noexcept {
  const std::uint8_t* const in = bytes_of(retry);
  if (!is_pending_ || find_attempt(load<std::int64_t>(in + kTimestampAt)) == nullptr) return false;
  if (!is_signed(handshake_key_, in, kRetryTagAt)) return false;
  std::copy_n(in + kCookieAt, cookie_.size(), cookie_.begin());
  return true;
}

bool ClientHandshake::read_reply(std::span<const std::byte> reply) noexcept {
  const std::uint8_t* const in = bytes_of(reply);
  const auto timestamp_ns = load<std::int64_t>(in + kTimestampAt);
  Attempt* const attempt = find_attempt(timestamp_ns);
  // The network may deliver a reply twice before the worker has finished with it.
  const bool is_again = attempt == nullptr && timestamp_ns == replied_request_ns_;
  if (!is_pending_ || (attempt == nullptr && !is_again) || !is_signed(handshake_key_, in, kReplyTagAt)) return false;
  if (is_again) return true;
  AgreementTask task;
  task.kind = AgreementTask::Kind::read_reply;
  task.number = handshake_number_;
  std::copy_n(in + kSecondAt, kSecondBytes, task.second.begin());
  task.state = attempt->state;
  if (!worker_.submit(task)) return false;
  replied_request_ns_ = attempt->timestamp_ns;
  *attempt = {};
  return true;
}

HubHandshake::HubHandshake(const LinkKey& master, AgreementWorker::Where where) : worker_(where) {
  for (std::uint8_t role = kFirstKeyRole; role <= kLastKeyRole; ++role) {
    const RoleKey key(master, static_cast<KeyRole>(role));
    keys_[role - kFirstKeyRole] = {derive_handshake_key(key), derive_psk(key)};
  }
  randombytes_buf(secret_.data(), secret_.size());
}

HubHandshake::~HubHandshake() {
  for (RoleKeys& keys : keys_) {
    wipe(keys.handshake);
    wipe(keys.psk);
  }
  wipe(secret_);
}

KeyRole HubHandshake::role_of(std::span<const std::byte> request) noexcept { return static_cast<KeyRole>(bytes_of(request)[kRoleAt]); }

HubHandshake::Verdict HubHandshake::check_request(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) noexcept {
  const std::uint8_t* const in = bytes_of(request);
  const auto role = find_node_key_role(in[kRoleAt]);
  if (!role) return Verdict::malformed;
  if (!is_signed(handshake_key(*role), in, kRequestTagAt)) return Verdict::wrong_key;
  if (!times_.accept(*role, load<std::uint64_t>(in + kHostAt), load<std::int64_t>(in + kRequestTimestampAt))) return Verdict::replayed;
  const std::int64_t period = now_ns / kCookieTimeNs;
  const auto has_cookie_of = [&](std::int64_t of_period) {
    const Cookie cookie = make_cookie(from, of_period);
    return sodium_memcmp(cookie.data(), in + kRequestCookieAt, cookie.size()) == 0;
  };
  return has_cookie_of(period) || has_cookie_of(period - 1) ? Verdict::shows_cookie : Verdict::wants_cookie;
}

std::size_t HubHandshake::write_retry(std::span<const std::byte> request, const Address& to, std::int64_t now_ns,
                                      std::span<std::byte> into) const noexcept {
  std::uint8_t* const out = bytes_of(into);
  const Cookie cookie = make_cookie(to, now_ns / kCookieTimeNs);
  write_lead(Kind::retry, out);
  store(load<std::int64_t>(bytes_of(request) + kRequestTimestampAt), out + kTimestampAt);
  std::copy(cookie.begin(), cookie.end(), out + kCookieAt);
  sign(handshake_key(role_of(request)), out, kRetryTagAt);
  return kRetryBytes;
}

Cookie HubHandshake::make_cookie(const Address& to, std::int64_t period) const noexcept {
  std::array<std::uint8_t, 8 + 16 + 2> text;
  store(period, text.data());
  std::copy(to.ip.begin(), to.ip.end(), text.data() + 8);
  store(to.port, text.data() + 24);
  Cookie cookie;
  crypto_generichash(cookie.data(), cookie.size(), text.data(), text.size(), secret_.data(), secret_.size());
  return cookie;
}

bool HubHandshake::agree(std::span<const std::byte> request, std::uint32_t connection) noexcept {
  const std::uint8_t* const in = bytes_of(request);
  AgreementTask task;
  task.kind = AgreementTask::Kind::reply_to_request;
  task.number = in[kRoleAt];
  task.connection = connection;
  task.timestamp_ns = load<std::int64_t>(in + kRequestTimestampAt);
  task.psk = keys_[task.number - kFirstKeyRole].psk;
  std::copy_n(in, kPrologueBytes, task.prologue.begin());
  std::copy_n(in + kFirstAt, kFirstBytes, task.first.begin());
  return worker_.submit(task);
}

bool HubHandshake::poll(Agreement& agreement) noexcept {
  AgreementTask task;
  if (!worker_.take(task)) return false;
  agreement.connection = task.connection;
  agreement.is_valid = task.is_valid;
  if (!task.is_valid) return true;
  std::uint8_t* const out = bytes_of(std::span<std::byte>(agreement.reply));
  write_lead(Kind::reply, out);
  store(task.timestamp_ns, out + kTimestampAt);
  std::copy(task.second.begin(), task.second.end(), out + kSecondAt);
  sign(handshake_key(static_cast<KeyRole>(task.number)), out, kReplyTagAt);
  agreement.channel = SealedChannel(task.keys, task.connection, SealedChannel::Side::hub);
  return true;
}

}  // namespace hapton
