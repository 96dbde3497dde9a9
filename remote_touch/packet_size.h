#pragma once

#include <cstddef>

#include "link/messages.h"

namespace hapton {

// Size of the IPv4 packet in which the nodes send this message, sealed. Units: bytes. RT: no. Threads: any.
std::size_t packet_bytes_of(const Message& message);

// The same for a DeviceState and for a ForceCommand with numbers that are usual in a session.
std::size_t packet_bytes_of_state();
std::size_t packet_bytes_of_force();

}  // namespace hapton
