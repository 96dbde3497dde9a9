#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "link/key_schedule.h"
#include "link/replay_window.h"
#include "link/seal_format.h"

namespace hapton {

// One side of one session: seals what goes to the other side and opens what comes from there. AES-256-GCM with a key for each
// direction and a counter for the nonce, which is never used twice; the whole header is authenticated. A datagram
// can be opened only once, only in this session, only by its intended receiver, and only if it is unchanged. RT: yes (no heap,
// lock, throw or system call). Threads: one.
class SealedChannel {
 public:
  enum class Side : std::uint8_t { client, hub };

  // Seals and opens nothing.
  SealedChannel() = default;
  // Pre: these keys were never given to a channel of this side before.
  SealedChannel(const seal::ChannelKeys& keys, std::uint32_t connection, Side side);
  ~SealedChannel();
  // Not copyable: a copy would use its counters twice. A moved-from channel seals and opens nothing.
  SealedChannel(SealedChannel&& other) noexcept;
  SealedChannel& operator=(SealedChannel&& other) noexcept;

  bool is_open() const noexcept { return is_open_; }
  // The number that the hub gave to the session; every datagram has it, unencrypted.
  std::uint32_t connection() const noexcept { return connection_; }
  // Datagrams sealed so far.
  std::uint64_t sealed() const noexcept { return counter_; }

  // Writes the sealed datagram and returns its size in bytes, payload + seal::kOverheadBytes. 0: the payload does not fit, or the channel
  // has no session.
  std::size_t seal(std::span<const std::byte> payload, std::span<std::byte> into) noexcept;

  // Post: unless opened, `into` holds nothing of the datagram and the channel is unchanged. Pre: into and datagram do not overlap.
  OpenStatus open(std::span<const std::byte> datagram, std::span<std::byte> into, std::size_t& bytes) noexcept;

 private:
  // A key as libsodium has expanded it.
  struct Cipher {
    alignas(16) std::array<std::uint8_t, 512> opaque;
  };

  void close() noexcept;

  bool is_open_ = false;
  std::uint32_t connection_ = 0;
  std::uint64_t counter_ = 0;
  Cipher seal_ = {};
  Cipher open_ = {};
  ReplayWindow window_;
};

}  // namespace hapton
