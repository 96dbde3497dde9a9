#pragma once

#include <cstdint>
#include <optional>

#include "link/key_schedule.h"
#include "link/sealed_channel.h"
#include "tests/fuzz/datagram_list.h"

// Sessions with known keys, one for each of the four nodes of a datagram list: what lies behind the seal of target `sealed`.
namespace hapton::fuzz {

// A data datagram as its holder reads it.
struct OpenedData {
  std::uint32_t connection = 0;
  std::uint64_t counter = 0;
  Bytes payload;
};

std::uint32_t connection_of(std::uint8_t node);
seal::SessionKeys session_keys_of(std::uint8_t node);
SealedChannel make_channel(std::uint8_t node, SealedChannel::Side side);

// With the key of its node and direction. Nothing when the seal does not hold. Pre: seal::start_crypto() went well.
std::optional<OpenedData> open_data(const ListedDatagram& datagram);
Bytes seal_data(const OpenedData& data, const ListedDatagram& as);

// A list of sealed datagrams with a change behind the seals, and the list sealed again; datagrams whose seal does not hold stay as they
// are.
Bytes mutate_sealed(std::span<const std::uint8_t> input, Mutation& mutation);
Bytes cross_sealed(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation);

}  // namespace hapton::fuzz
