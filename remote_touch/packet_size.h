#pragma once

#include <cstddef>

#include "link/messages.h"

namespace hapton {

// Size of the IPv4 packet in which the nodes send this message, sealed. Units: bytes. RT: no. Threads: any.
std::size_t packet_bytes_of(const Message& message);

// Of a DeviceState and of a ForceCommand with numbers as they are in a session.
std::size_t packet_bytes_of_state();
std::size_t packet_bytes_of_force();

}  // namespace hapton
