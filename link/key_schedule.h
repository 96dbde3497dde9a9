#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "link/link_key.h"
#include "link/seal_format.h"

namespace hapton {

// Derives the key of a role from the master key, and from that the keys that authenticate and decrypt its handshakes: keyed BLAKE2b, with a
// different label for each derived key, so that no key has two purposes. The keys of a session come from the Noise handshake (noise.h).
// docs/formats.md describes it in words; tests/link/key_schedule_test.cpp has known answers. RT: yes (no heap, lock, throw or system call).
// Threads: any.
namespace seal {

using Secret = std::array<std::uint8_t, 32>;
using Tag = std::array<std::uint8_t, kTagBytes>;

// The session keys of a SealedChannel, one for each direction; wiped on destruction.
struct ChannelKeys {
  Secret client_to_hub = {};
  Secret hub_to_client = {};

  ChannelKeys() = default;
  ~ChannelKeys();
  ChannelKeys(const ChannelKeys&) = default;
  ChannelKeys& operator=(const ChannelKeys&) = default;
};

// The key of a role, from the master key. The same in every protocol version: a node's key file outlives an update.
Secret derive_role_key(const LinkKey& master, KeyRole role) noexcept;

// Derive from a role's key the key for the tags of its handshakes, and the psk of its Noise handshakes. Different in every version.
Secret derive_handshake_key(const RoleKey& key) noexcept;
Secret derive_psk(const RoleKey& key) noexcept;

Tag compute_tag(const Secret& key, std::span<const std::uint8_t> bytes) noexcept;
// Compares in constant time. found: kTagBytes bytes.
bool is_tag(const Tag& expected, const std::uint8_t* found) noexcept;

void wipe(Secret& secret) noexcept;

// To be called before any of the above; may be called again. find_link_key and read_key_file do it. RT: set-up only.
// Error: the system has no random numbers, or the processor no AES instructions.
Result<void> start_crypto();

}  // namespace seal
}  // namespace hapton
