#pragma once

#include <optional>
#include <span>
#include <vector>

#include "tests/fuzz/mutation.h"

namespace hapton::fuzz {

// The messages of a recorded session, without length and check. Nothing when the file does not begin as one; damage ends the list.
std::optional<std::vector<Bytes>> split_session(std::span<const std::uint8_t> file);
// With the lengths and checks that belong to them.
Bytes join_session(const std::vector<Bytes>& messages);

// A recorded session with a change in one message, whose check holds again.
Bytes mutate_session(std::span<const std::uint8_t> file, Mutation& mutation);
Bytes cross_sessions(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation);

}  // namespace hapton::fuzz
