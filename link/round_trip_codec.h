#pragma once

#include <cstddef>
#include <span>

#include "link/messages.h"

namespace hapton {

// DeviceState and ForceCommand, the two messages of a round trip, in one pass over their bytes. Their layout is fixed (proto/hapton.proto,
// Lengths), so nothing else is needed; protobuf's objects for them touch many times as much memory, which is cold once a cycle.
// The bytes are those that protobuf writes. Used by codec.cpp alone, which states the contract. RT: yes.

// Returns the size; 0: it does not fit, or is another message.
std::size_t encode_round_trip(const Datagram& datagram, std::span<std::byte> into) noexcept;

// False, and `datagram` unchanged: another message or version, other fields or another order of fields, or a value that the contract rules
// out. The general decoder says which; it accepts whatever this one accepts, with the same result.
bool decode_round_trip(std::span<const std::byte> bytes, Datagram& datagram) noexcept;

}  // namespace hapton
