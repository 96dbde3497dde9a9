#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace hapton {

// The bytes of the one message in an Envelope of proto/hapton.proto, which a program can read with the schema of that message alone. Empty:
// no message, an empty one, or damaged bytes. Post: within `envelope`. RT: yes.
std::string_view find_message_payload(std::span<const std::byte> envelope) noexcept;

}  // namespace hapton
