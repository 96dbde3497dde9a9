#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace hapton::noise {

// The handshake pattern NNpsk0 of the Noise protocol framework, with X25519, AES-256-GCM and SHA-256:
//
//   -> psk, e
//   <- e, ee
//
// Both sides hold a secret (the psk); each adds a key pair of its own that lives for one handshake. A party without the psk can neither
// make nor read messages of the handshake, and one that learns the psk later cannot open a past session: its keys depend on both pairs.
// A prologue is what both sides must agree on without sending it in the messages.
// Source: "The Noise Protocol Framework", revision 34, sections 5, 7, 9 and 12. Tested against the vectors of the Cacophony library.
// RT: no: X25519 takes 25 to 60 us each time. No heap, lock or throw. Threads: any.
constexpr std::string_view kProtocolName = "Noise_NNpsk0_25519_AESGCM_SHA256";

constexpr std::size_t kKeyBytes = 32;
constexpr std::size_t kTagBytes = 16;
// What each of the two messages adds to its payload: a public key and a tag.
constexpr std::size_t kMessageOverhead = kKeyBytes + kTagBytes;

using Key = std::array<std::uint8_t, kKeyBytes>;

// The keys of the transport, one each way.
struct TransportKeys {
  Key initiator_to_responder = {};
  Key responder_to_initiator = {};
};

// Seal and open as Noise's cipher functions do: nonce n, associated data ad. encrypt writes payload.size() + kTagBytes
// bytes to `into`, decrypt sealed.size() - kTagBytes. decrypt returns false if `sealed` is too short or its tag is wrong.
void encrypt(const Key& key, std::uint64_t n, std::span<const std::uint8_t> ad, std::span<const std::uint8_t> payload,
             std::uint8_t* into) noexcept;
bool decrypt(const Key& key, std::uint64_t n, std::span<const std::uint8_t> ad, std::span<const std::uint8_t> sealed,
             std::uint8_t* into) noexcept;

// What one side knows of a handshake at any moment: Noise's SymmetricState and its own key pair. Wiped on destruction.
class HandshakeState {
 public:
  HandshakeState() = default;
  ~HandshakeState();
  HandshakeState(const HandshakeState&) = default;
  HandshakeState& operator=(const HandshakeState&) = default;

  // Begins a handshake, on either side. own_secret: 32 random bytes for this handshake alone. Pre: seal::start_crypto() succeeded.
  void begin(const Key& psk, std::span<const std::uint8_t> prologue, const Key& own_secret) noexcept;

  // For the initiator: writes "psk, e" and the payload; reads the reply. Writing puts payload.size() + kMessageOverhead bytes into `into`,
  // on either side, and reading message.size() - kMessageOverhead.
  void write_first(std::span<const std::uint8_t> payload, std::uint8_t* into) noexcept;
  bool read_second(std::span<const std::uint8_t> message, std::uint8_t* into) noexcept;

  // For the responder. read_first and read_second return false if the message was made without the psk, was changed, or is for another
  // prologue; read_second and write_second also if no secret can be computed from the other side's public key. After false only begin may
  // follow.
  bool read_first(std::span<const std::uint8_t> message, std::uint8_t* into) noexcept;
  bool write_second(std::span<const std::uint8_t> payload, std::uint8_t* into) noexcept;

  // Pre: both messages were processed successfully.
  TransportKeys split() const noexcept;
  const Key& handshake_hash() const noexcept { return hash_; }

  void wipe() noexcept;

 private:
  void mix_key(std::span<const std::uint8_t> input) noexcept;
  void mix_hash(std::span<const std::uint8_t> text) noexcept;
  void mix_key_and_hash(std::span<const std::uint8_t> input) noexcept;
  void encrypt_and_hash(std::span<const std::uint8_t> payload, std::uint8_t* into) noexcept;
  bool decrypt_and_hash(std::span<const std::uint8_t> sealed, std::uint8_t* into) noexcept;
  bool mix_shared_secret() noexcept;
  void take_own_public(std::uint8_t* into) noexcept;
  void take_their_public(const std::uint8_t* from) noexcept;

  Key chaining_key_ = {};  // ck
  Key hash_ = {};          // h
  Key key_ = {};           // k
  std::uint64_t n_ = 0;
  Key own_secret_ = {};    // e
  Key their_public_ = {};  // re
};

}  // namespace hapton::noise
