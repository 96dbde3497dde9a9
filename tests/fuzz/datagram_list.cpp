#include "tests/fuzz/datagram_list.h"

#include <algorithm>

#include "link/memory_endpoint.h"

namespace hapton::fuzz {

std::vector<ListedDatagram> split_datagrams(std::span<const std::uint8_t> input) {
  std::vector<ListedDatagram> datagrams;
  while (input.size() >= 3) {
    const std::size_t size = std::min<std::size_t>(input[1] | input[2] << 8, input.size() - 3);
    const auto bytes = input.subspan(3, size);
    datagrams.push_back({input[0], Bytes(bytes.begin(), bytes.end())});
    input = input.subspan(3 + size);
  }
  return datagrams;
}

Bytes join_datagrams(const std::vector<ListedDatagram>& datagrams) {
  Bytes input;
  for (const ListedDatagram& datagram : datagrams) {
    const std::size_t size = std::min<std::size_t>(datagram.bytes.size(), 0xFFFF);
    input.push_back(datagram.flags);
    input.push_back(static_cast<std::uint8_t>(size));
    input.push_back(static_cast<std::uint8_t>(size >> 8));
    input.insert(input.end(), datagram.bytes.begin(), datagram.bytes.begin() + static_cast<std::ptrdiff_t>(size));
  }
  return input;
}

std::span<const std::byte> as_datagram(const Bytes& bytes) { return std::as_bytes(std::span(bytes)); }
Address address_of_node(std::uint8_t node) { return memory_address(static_cast<std::uint8_t>(2 + node), 9); }
Address address_of_hub() { return memory_address(1, 4950); }

}  // namespace hapton::fuzz
