#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace hapton {

// The one message of an Envelope of proto/hapton.proto, as it stands in these bytes: what a program reads with that message's own schema.
// Empty where there is none. Post: within `envelope`. RT: yes.
std::string_view find_message_payload(std::span<const std::byte> envelope) noexcept;

}  // namespace hapton
