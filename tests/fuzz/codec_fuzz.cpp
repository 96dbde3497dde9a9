// Any bytes as a datagram: rejected, or a message that can be encoded and decoded again.
#include "link/codec.h"
#include "link/endpoint.h"
#include "tests/fuzz/fuzz_target.h"
#include "tests/fuzz/proto_mutator.h"

FUZZ_TARGET(codec) {
  using namespace hapton;
  static Codec codec;
  Datagram received;
  const DecodeStatus status = codec.decode(std::as_bytes(bytes), received);
  if (status != DecodeStatus::truncated && status != DecodeStatus::wrong_version) fuzz::note_passage();
  if (status != DecodeStatus::ok) return;
  std::array<std::byte, kMaxDatagramBytes> encoded;
  const std::size_t size = codec.encode(received, encoded);
  if (size == 0) return;  // too long: unknown fields are dropped, but optional vectors that were absent are written
  Datagram again;
  fuzz::require(codec.decode(std::span(encoded).first(size), again) == DecodeStatus::ok);
  fuzz::require(again.message.index() == received.message.index());
  fuzz::require(again.header.sequence == received.header.sequence);
}

namespace {

// Each message is protobuf, in which a length stands before each nested content: mutate_proto() keeps these lengths right.
hapton::fuzz::Bytes mutate_message(std::span<const std::uint8_t> message, hapton::fuzz::Mutation& mutation) {
  return hapton::fuzz::mutate_proto(hapton::fuzz::Bytes(message.begin(), message.end()), mutation);
}

}  // namespace

FUZZ_MUTATOR(codec, mutate_message);
