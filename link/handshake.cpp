#include "link/handshake.h"

#include <sodium.h>

#include <algorithm>
#include <cstring>

namespace hapton {

using namespace seal;

namespace {

// What a hub makes out of its own secret; the first byte keeps the two apart.
enum class Purpose : std::uint8_t { cookie = 1, nonce = 2 };

std::span<const std::uint8_t> signed_part(const std::uint8_t* in, std::size_t tag_at) { return {in, tag_at}; }

void sign(const Secret& key, std::uint8_t* out, std::size_t tag_at) {
  const Tag tag = compute_tag(key, signed_part(out, tag_at));
  std::copy(tag.begin(), tag.end(), out + tag_at);
}

bool is_signed(const Secret& key, const std::uint8_t* in, std::size_t tag_at) {
  return is_tag(compute_tag(key, signed_part(in, tag_at)), in + tag_at);
}

// A request and a retry look alike.
std::size_t write_nonce_and_cookie(Kind kind, const Nonce& nonce, const Cookie& cookie, const Secret& key, std::uint8_t* out) {
  write_lead(kind, out);
  std::copy(nonce.begin(), nonce.end(), out + kNonceAt);
  std::copy(cookie.begin(), cookie.end(), out + kCookieAt);
  sign(key, out, kRequestTagAt);
  return kRequestBytes;
}

}  // namespace

ClientHandshake::ClientHandshake(const LinkKey& key) : key_(key), handshake_key_(derive_handshake_key(key)) {}

ClientHandshake::~ClientHandshake() { wipe(handshake_key_); }

void ClientHandshake::begin() noexcept {
  randombytes_buf(nonce_.data(), nonce_.size());
  cookie_ = {};
  is_pending_ = true;
}

std::size_t ClientHandshake::write_request(std::span<std::byte> into) const noexcept {
  return write_nonce_and_cookie(Kind::request, nonce_, cookie_, handshake_key_, bytes_of(into));
}

ClientHandshake::Heard ClientHandshake::read(Kind kind, std::span<const std::byte> datagram) noexcept {
  if (!is_pending_) return Heard::nothing;
  if (kind == Kind::retry) return read_retry(bytes_of(datagram));
  return kind == Kind::answer ? read_answer(datagram) : Heard::nothing;
}

ClientHandshake::Heard ClientHandshake::read_retry(const std::uint8_t* in) noexcept {
  if (!std::equal(nonce_.begin(), nonce_.end(), in + kNonceAt) || !is_signed(handshake_key_, in, kRequestTagAt)) return Heard::nothing;
  std::copy_n(in + kCookieAt, cookie_.size(), cookie_.begin());
  return Heard::cookie;
}

ClientHandshake::Heard ClientHandshake::read_answer(std::span<const std::byte> datagram) noexcept {
  const std::uint8_t* const in = bytes_of(datagram);
  Nonce hub_nonce;
  std::copy_n(in + kHubNonceAt, hub_nonce.size(), hub_nonce.begin());
  const SessionKeys keys = derive_session_keys(key_, nonce_, hub_nonce);
  if (!is_signed(keys.answer, in, kAnswerTagAt)) return Heard::nothing;
  channel_ = SealedChannel(keys, load<std::uint32_t>(in + kConnectionAt), SealedChannel::Side::client);
  is_pending_ = false;
  return Heard::agreement;
}

HubHandshake::HubHandshake(const LinkKey& key) : key_(key), handshake_key_(derive_handshake_key(key)) {
  randombytes_buf(secret_.data(), secret_.size());
}

HubHandshake::~HubHandshake() {
  wipe(handshake_key_);
  wipe(secret_);
}

Nonce HubHandshake::nonce_of(std::span<const std::byte> request) noexcept {
  Nonce nonce;
  std::copy_n(bytes_of(request) + kNonceAt, nonce.size(), nonce.begin());
  return nonce;
}

HubHandshake::Verdict HubHandshake::judge(std::span<const std::byte> request, const Address& from, std::int64_t now_ns) const noexcept {
  const std::uint8_t* const in = bytes_of(request);
  if (!is_signed(handshake_key_, in, kRequestTagAt)) return Verdict::stranger;
  const Nonce nonce = nonce_of(request);
  const std::int64_t period = now_ns / kCookieTimeNs;
  const auto is_good = [&](std::int64_t of_period) {
    const Cookie cookie = make_cookie(nonce, from, of_period);
    return sodium_memcmp(cookie.data(), in + kCookieAt, cookie.size()) == 0;
  };
  return is_good(period) || is_good(period - 1) ? Verdict::shows_cookie : Verdict::wants_cookie;
}

std::size_t HubHandshake::write_retry(const Nonce& client_nonce, const Address& to, std::int64_t now_ns,
                                      std::span<std::byte> into) const noexcept {
  const Cookie cookie = make_cookie(client_nonce, to, now_ns / kCookieTimeNs);
  return write_nonce_and_cookie(Kind::retry, client_nonce, cookie, handshake_key_, bytes_of(into));
}

Cookie HubHandshake::make_cookie(const Nonce& client_nonce, const Address& to, std::int64_t period) const noexcept {
  std::array<std::uint8_t, 1 + 8 + 16 + 2 + kNonceBytes> text;
  text[0] = static_cast<std::uint8_t>(Purpose::cookie);
  store(period, text.data() + 1);
  std::copy(to.ip.begin(), to.ip.end(), text.data() + 9);
  store(to.port, text.data() + 25);
  std::copy(client_nonce.begin(), client_nonce.end(), text.data() + 27);
  Cookie cookie;
  crypto_generichash(cookie.data(), cookie.size(), text.data(), text.size(), secret_.data(), secret_.size());
  return cookie;
}

SealedChannel HubHandshake::agree(const Nonce& client_nonce, std::uint32_t connection, std::span<std::byte> into) noexcept {
  // Never the same twice: the count within one start of the hub, the secret from one start to the next.
  std::array<std::uint8_t, 1 + 8> text;
  text[0] = static_cast<std::uint8_t>(Purpose::nonce);
  store(++sessions_, text.data() + 1);
  Nonce hub_nonce;
  crypto_generichash(hub_nonce.data(), hub_nonce.size(), text.data(), text.size(), secret_.data(), secret_.size());

  const SessionKeys keys = derive_session_keys(key_, client_nonce, hub_nonce);
  std::uint8_t* const out = bytes_of(into);
  write_lead(Kind::answer, out);
  store(connection, out + kConnectionAt);
  std::copy(hub_nonce.begin(), hub_nonce.end(), out + kHubNonceAt);
  sign(keys.answer, out, kAnswerTagAt);
  return SealedChannel(keys, connection, SealedChannel::Side::hub);
}

}  // namespace hapton
