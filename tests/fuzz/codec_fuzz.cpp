// Any bytes as a datagram: refused, or a message that can be said again and is then understood.
#include "link/codec.h"
#include "link/endpoint.h"
#include "tests/fuzz/fuzz_target.h"

FUZZ_TARGET(codec) {
  using namespace hapton;
  static Codec codec;
  Datagram heard;
  if (codec.decode(std::as_bytes(bytes), heard) != DecodeStatus::ok) return;
  std::array<std::byte, kMaxDatagramBytes> said;
  const std::size_t size = codec.encode(heard, said);
  if (size == 0) return;  // unknown fields are not kept, so that it can only become shorter
  Datagram again;
  fuzz::require(codec.decode(std::span(said).first(size), again) == DecodeStatus::ok);
  fuzz::require(again.message.index() == heard.message.index());
  fuzz::require(again.header.sequence == heard.header.sequence);
}
