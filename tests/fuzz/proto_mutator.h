#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tests/fuzz/mutation.h"

namespace hapton::fuzz {

// One field of a protobuf message on the wire; what it means is not known here.
struct ProtoField {
  enum class Type : std::uint8_t { varint = 0, fixed64 = 1, bytes = 2, fixed32 = 5 };
  std::uint32_t number = 1;
  Type type = Type::varint;
  std::uint64_t value = 0;  // of all but bytes
  Bytes bytes;              // of bytes: text, a message within, packed numbers

  bool operator==(const ProtoField&) const = default;
};

// Nothing when the bytes are not a whole message (or use groups).
std::optional<std::vector<ProtoField>> split_proto(std::span<const std::uint8_t> message);
Bytes join_proto(const std::vector<ProtoField>& fields);

// Changes a field of the message, at any depth, or which fields there are; lengths fit again. Bytes that are not a message are changed
// plainly.
Bytes mutate_proto(const Bytes& message, Mutation& mutation, int depth = 0);

}  // namespace hapton::fuzz
