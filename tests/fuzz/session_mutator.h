#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tests/fuzz/mutation.h"

namespace hapton::fuzz {

// The messages of a recorded session, without lengths and checksums; nothing if the file has no session header. Damage ends the list.
std::optional<std::vector<Bytes>> split_session(std::span<const std::uint8_t> file);
// Gives each message its length and its checksum.
Bytes join_session(const std::vector<Bytes>& messages);

// Changes one message of a recorded session, and makes its checksum valid again.
Bytes mutate_session(std::span<const std::uint8_t> file, Mutation& mutation);
Bytes cross_sessions(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation);

}  // namespace hapton::fuzz
