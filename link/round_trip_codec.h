#pragma once

#include <cstddef>
#include <span>

#include "link/messages.h"

namespace hapton {

// Encode and decode DeviceState and ForceCommand, the two messages of a round trip, in one pass over their bytes. Their layout is fixed
// (proto/hapton.proto, Lengths), so nothing else is needed; protobuf's objects for them touch many times as much memory, which has left the
// cache by the next cycle. The bytes are those that protobuf writes. Only codec.cpp uses this; codec.h states the contract. RT: yes.

// Returns the size in bytes; 0 if the datagram does not fit, or is another message.
std::size_t encode_round_trip(const Datagram& datagram, std::span<std::byte> into) noexcept;

// Returns false and leaves `datagram` unchanged for another message or version, other fields or another order of fields, or a value that
// the contract rules out. The general decoder tells which; it accepts whatever this function accepts, with the same result.
bool decode_round_trip(std::span<const std::byte> bytes, Datagram& datagram) noexcept;

}  // namespace hapton
