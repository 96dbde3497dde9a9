#include "link/sealed_channel.h"

#include <sodium.h>

#include <utility>

namespace hapton {
namespace {

using namespace seal;

// The nonce that Noise specifies for AES-256-GCM: 32 bits of zeros, then the counter, big-endian.
std::array<std::uint8_t, crypto_aead_aes256gcm_NPUBBYTES> nonce_of(std::uint64_t counter) {
  std::array<std::uint8_t, crypto_aead_aes256gcm_NPUBBYTES> nonce = {};
  store(__builtin_bswap64(counter), nonce.data() + 4);
  return nonce;
}

template <class Cipher>
crypto_aead_aes256gcm_state* expanded(Cipher& cipher) {
  static_assert(sizeof(Cipher) == sizeof(crypto_aead_aes256gcm_state) && alignof(Cipher) >= alignof(crypto_aead_aes256gcm_state));
  return reinterpret_cast<crypto_aead_aes256gcm_state*>(&cipher);
}

}  // namespace

SealedChannel::SealedChannel(const ChannelKeys& keys, std::uint32_t connection, Side side) : is_open_(true), connection_(connection) {
  crypto_aead_aes256gcm_beforenm(expanded(seal_), (side == Side::client ? keys.client_to_hub : keys.hub_to_client).data());
  crypto_aead_aes256gcm_beforenm(expanded(open_), (side == Side::client ? keys.hub_to_client : keys.client_to_hub).data());
}

SealedChannel::~SealedChannel() { close(); }

SealedChannel::SealedChannel(SealedChannel&& other) noexcept { *this = std::move(other); }

SealedChannel& SealedChannel::operator=(SealedChannel&& other) noexcept {
  is_open_ = other.is_open_;
  connection_ = other.connection_;
  counter_ = other.counter_;
  seal_ = other.seal_;
  open_ = other.open_;
  window_ = other.window_;
  if (this != &other) other.close();
  return *this;
}

void SealedChannel::close() noexcept {
  is_open_ = false;
  sodium_memzero(&seal_, sizeof seal_);
  sodium_memzero(&open_, sizeof open_);
}

std::size_t SealedChannel::seal(std::span<const std::byte> payload, std::span<std::byte> into) noexcept {
  const std::size_t bytes = payload.size() + kOverheadBytes;
  if (!is_open_ || payload.size() > kMaxPayloadBytes || into.size() < bytes) return 0;
  std::uint8_t* const out = bytes_of(into);
  write_lead(Kind::data, out);
  store(connection_, out + kConnectionAt);
  store(++counter_, out + kCounterAt);
  crypto_aead_aes256gcm_encrypt_detached_afternm(out + kHeaderBytes, out + kHeaderBytes + payload.size(), nullptr, bytes_of(payload),
                                                 payload.size(), out, kHeaderBytes, nullptr, nonce_of(counter_).data(), expanded(seal_));
  return bytes;
}

OpenStatus SealedChannel::open(std::span<const std::byte> datagram, std::span<std::byte> into, std::size_t& bytes) noexcept {
  const SealedKind found = classify_sealed(datagram);
  if (found.status != OpenStatus::opened) return found.status;
  if (found.kind != Kind::data) return OpenStatus::malformed;
  const std::uint8_t* const in = bytes_of(datagram);
  if (!is_open_ || load<std::uint32_t>(in + kConnectionAt) != connection_) return OpenStatus::unknown_session;
  const auto counter = load<std::uint64_t>(in + kCounterAt);
  if (!window_.is_fresh(counter)) return OpenStatus::replayed;
  const std::size_t payload = datagram.size() - kOverheadBytes;
  if (into.size() < payload) return OpenStatus::malformed;
  if (crypto_aead_aes256gcm_decrypt_detached_afternm(bytes_of(into), nullptr, in + kHeaderBytes, payload, in + kHeaderBytes + payload, in,
                                                     kHeaderBytes, nonce_of(counter).data(), expanded(open_)) != 0) {
    return OpenStatus::forged;
  }
  window_.mark(counter);
  bytes = payload;
  return OpenStatus::opened;
}

}  // namespace hapton
