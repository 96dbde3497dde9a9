#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/result.h"
#include "link/link_key.h"
#include "link/seal_format.h"

namespace hapton {

// From the shared key to the keys of a session: BLAKE2b, keyed, with a label and the protocol version in all that is derived, so that no
// key serves two purposes or two versions. docs/formats.md has it in words; tests/link/key_schedule_test.cpp holds known answers.
// RT: yes (no heap, lock, throw or system call). Threads: any.
namespace seal {

using Secret = std::array<std::uint8_t, 32>;
using Tag = std::array<std::uint8_t, kTagBytes>;

// The keys of one session, one each way; wiped when they go.
struct SessionKeys {
  Secret client_to_hub = {};
  Secret hub_to_client = {};
  Secret answer = {};  // proves the hub's answer

  SessionKeys() = default;
  ~SessionKeys();
  SessionKeys(const SessionKeys&) = default;
  SessionKeys& operator=(const SessionKeys&) = default;
};

// Proves requests and retries.
Secret derive_handshake_key(const LinkKey& key) noexcept;

// Both nonces are in it: neither side alone can bring an old session's keys back.
SessionKeys derive_session_keys(const LinkKey& key, const Nonce& client_nonce, const Nonce& hub_nonce) noexcept;

Tag compute_tag(const Secret& key, std::span<const std::uint8_t> bytes) noexcept;
// In the same time whatever differs.
bool is_tag(const Tag& expected, const std::uint8_t* found) noexcept;

void wipe(Secret& secret) noexcept;

// Before any of the above; more often does no harm. find_link_key and read_key_file do it. RT: set-up only.
// Error: the system has no random numbers, or the processor no AES instructions.
Result<void> start_crypto();

}  // namespace seal
}  // namespace hapton
