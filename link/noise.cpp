#include "link/noise.h"

#include <sodium.h>

#include <algorithm>

namespace hapton::noise {
namespace {

static_assert(kProtocolName.size() == crypto_hash_sha256_BYTES);  // so h begins as the name itself (Noise specification, section 5.2)
static_assert(kKeyBytes == crypto_aead_aes256gcm_KEYBYTES && kTagBytes == crypto_aead_aes256gcm_ABYTES);
static_assert(kKeyBytes == crypto_scalarmult_BYTES && kKeyBytes == crypto_scalarmult_SCALARBYTES);

using Nonce = std::array<std::uint8_t, crypto_aead_aes256gcm_NPUBBYTES>;

// 32 bits of zeros, then n, big-endian: section 12.4 of the Noise specification, as are all sections named below.
Nonce nonce_of(std::uint64_t n) noexcept {
  Nonce nonce = {};
  for (std::size_t i = 0; i < 8; ++i) nonce[nonce.size() - 1 - i] = static_cast<std::uint8_t>(n >> (8 * i));
  return nonce;
}

void hmac(const Key& key, std::span<const std::uint8_t> text, std::uint8_t last, bool has_last, Key& into) noexcept {
  crypto_auth_hmacsha256_state state;
  crypto_auth_hmacsha256_init(&state, key.data(), key.size());
  crypto_auth_hmacsha256_update(&state, text.data(), text.size());
  if (has_last) crypto_auth_hmacsha256_update(&state, &last, 1);
  crypto_auth_hmacsha256_final(&state, into.data());
  sodium_memzero(&state, sizeof state);
}

// The function HKDF of section 4.3. out3 may be null; out1 may be the chaining key.
void hkdf(const Key& chaining_key, std::span<const std::uint8_t> input, Key& out1, Key& out2, Key* out3) noexcept {
  Key temp;
  hmac(chaining_key, input, 0, false, temp);
  hmac(temp, {}, 1, true, out1);
  hmac(temp, out1, 2, true, out2);
  if (out3 != nullptr) hmac(temp, out2, 3, true, *out3);
  sodium_memzero(temp.data(), temp.size());
}

}  // namespace

void encrypt(const Key& key, std::uint64_t n, std::span<const std::uint8_t> ad, std::span<const std::uint8_t> payload,
             std::uint8_t* into) noexcept {
  crypto_aead_aes256gcm_encrypt(into, nullptr, payload.data(), payload.size(), ad.data(), ad.size(), nullptr, nonce_of(n).data(),
                                key.data());
}

bool decrypt(const Key& key, std::uint64_t n, std::span<const std::uint8_t> ad, std::span<const std::uint8_t> sealed,
             std::uint8_t* into) noexcept {
  if (sealed.size() < kTagBytes) return false;
  return crypto_aead_aes256gcm_decrypt(into, nullptr, nullptr, sealed.data(), sealed.size(), ad.data(), ad.size(), nonce_of(n).data(),
                                       key.data()) == 0;
}

HandshakeState::~HandshakeState() { wipe(); }

void HandshakeState::wipe() noexcept {
  for (Key* key : {&chaining_key_, &hash_, &key_, &own_secret_, &their_public_}) sodium_memzero(key->data(), key->size());
  n_ = 0;
}

void HandshakeState::begin(const Key& psk, std::span<const std::uint8_t> prologue, const Key& own_secret) noexcept {
  std::copy(kProtocolName.begin(), kProtocolName.end(), hash_.begin());
  chaining_key_ = hash_;
  own_secret_ = own_secret;
  mix_hash(prologue);
  mix_key_and_hash(psk);  // token "psk", which both sides process before the first message's "e"
}

void HandshakeState::mix_key(std::span<const std::uint8_t> input) noexcept {
  hkdf(chaining_key_, input, chaining_key_, key_, nullptr);
  n_ = 0;
}

void HandshakeState::mix_hash(std::span<const std::uint8_t> text) noexcept {
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  crypto_hash_sha256_update(&state, hash_.data(), hash_.size());
  crypto_hash_sha256_update(&state, text.data(), text.size());
  crypto_hash_sha256_final(&state, hash_.data());
}

void HandshakeState::mix_key_and_hash(std::span<const std::uint8_t> input) noexcept {
  Key temp;
  hkdf(chaining_key_, input, chaining_key_, temp, &key_);
  mix_hash(temp);
  n_ = 0;
  sodium_memzero(temp.data(), temp.size());
}

void HandshakeState::encrypt_and_hash(std::span<const std::uint8_t> payload, std::uint8_t* into) noexcept {
  encrypt(key_, n_++, hash_, payload, into);
  mix_hash({into, payload.size() + kTagBytes});
}

bool HandshakeState::decrypt_and_hash(std::span<const std::uint8_t> sealed, std::uint8_t* into) noexcept {
  if (!decrypt(key_, n_, hash_, sealed, into)) return false;
  ++n_;
  mix_hash(sealed);
  return true;
}

// With a psk, every "e" is mixed into the key as well (section 9.2).
void HandshakeState::take_own_public(std::uint8_t* into) noexcept {
  crypto_scalarmult_base(into, own_secret_.data());
  mix_hash({into, kKeyBytes});
  mix_key({into, kKeyBytes});
}

void HandshakeState::take_their_public(const std::uint8_t* from) noexcept {
  std::copy_n(from, kKeyBytes, their_public_.begin());
  mix_hash(their_public_);
  mix_key(their_public_);
}

// Token "ee". False for a public key of small order, which fixes the result whatever the own secret is.
bool HandshakeState::mix_shared_secret() noexcept {
  Key shared;
  const bool is_good = crypto_scalarmult(shared.data(), own_secret_.data(), their_public_.data()) == 0;
  if (is_good) mix_key(shared);
  sodium_memzero(shared.data(), shared.size());
  sodium_memzero(own_secret_.data(), own_secret_.size());  // no longer needed
  return is_good;
}

void HandshakeState::write_first(std::span<const std::uint8_t> payload, std::uint8_t* into) noexcept {
  take_own_public(into);
  encrypt_and_hash(payload, into + kKeyBytes);
}

bool HandshakeState::read_first(std::span<const std::uint8_t> message, std::uint8_t* into) noexcept {
  if (message.size() < kMessageOverhead) return false;
  take_their_public(message.data());
  return decrypt_and_hash(message.subspan(kKeyBytes), into);
}

bool HandshakeState::write_second(std::span<const std::uint8_t> payload, std::uint8_t* into) noexcept {
  take_own_public(into);
  if (!mix_shared_secret()) return false;
  encrypt_and_hash(payload, into + kKeyBytes);
  return true;
}

bool HandshakeState::read_second(std::span<const std::uint8_t> message, std::uint8_t* into) noexcept {
  if (message.size() < kMessageOverhead) return false;
  take_their_public(message.data());
  return mix_shared_secret() && decrypt_and_hash(message.subspan(kKeyBytes), into);
}

TransportKeys HandshakeState::split() const noexcept {
  TransportKeys keys;
  hkdf(chaining_key_, {}, keys.initiator_to_responder, keys.responder_to_initiator, nullptr);
  return keys;
}

}  // namespace hapton::noise
