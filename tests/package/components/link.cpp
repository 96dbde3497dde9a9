// Component link alone: encodes and decodes a force in the wire format.
#include <array>
#include <cstdio>
#include <span>

#include "link/codec.h"
#include "link/endpoint.h"

int main() {
  using namespace hapton;
  Codec codec;
  std::array<std::byte, kMaxDatagramBytes> bytes;
  ForceCommand command;
  command.force_n = {0, 0, 2};
  const std::size_t size = codec.encode({{1, 2, 3, 4}, command}, bytes);
  Datagram received;
  if (codec.decode(std::span(bytes).first(size), received) != DecodeStatus::ok) return 1;
  std::printf("%zu bytes\n", size);
  return std::get<ForceCommand>(received.message).force_n.z() == 2.0 ? 0 : 1;
}
