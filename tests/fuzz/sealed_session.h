#pragma once

#include <cstdint>
#include <optional>

#include "link/key_schedule.h"
#include "link/sealed_channel.h"
#include "tests/fuzz/datagram_list.h"

// Sessions with known keys, one for each of the four nodes of a datagram list, so that target `sealed` can fuzz the content of sealed
// datagrams.
namespace hapton::fuzz {

// A data datagram after decryption.
struct OpenedData {
  std::uint32_t connection = 0;
  std::uint64_t counter = 0;
  Bytes payload;
};

std::uint32_t connection_of(std::uint8_t node);
seal::ChannelKeys session_keys_of(std::uint8_t node);
SealedChannel make_channel(std::uint8_t node, SealedChannel::Side side);

// Decrypts with the key of its node and direction. None: the seal is not valid. Pre: seal::start_crypto() succeeded.
std::optional<OpenedData> open_data(const ListedDatagram& datagram);
// Encrypts with the key of the node and direction of `route`.
Bytes seal_data(const OpenedData& data, const ListedDatagram& route);

// Opens the datagrams of a list, mutates their content and seals them again. Datagrams whose seal is not valid are kept unchanged.
Bytes mutate_sealed(std::span<const std::uint8_t> input, Mutation& mutation);
Bytes cross_sealed(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation);

}  // namespace hapton::fuzz
