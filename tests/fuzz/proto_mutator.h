#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "tests/fuzz/mutation.h"

namespace hapton::fuzz {

// One field of a protobuf message as it is sent; this code does not know its meaning.
struct ProtoField {
  enum class Type : std::uint8_t { varint = 0, fixed64 = 1, bytes = 2, fixed32 = 5 };
  std::uint32_t number = 1;
  Type type = Type::varint;
  std::uint64_t value = 0;  // for every type but bytes
  Bytes bytes;              // for type bytes: text, a nested message, packed numbers

  bool operator==(const ProtoField&) const = default;
};

// Nothing when the bytes are not a whole message (or use groups).
std::optional<std::vector<ProtoField>> split_proto(std::span<const std::uint8_t> message);
Bytes join_proto(const std::vector<ProtoField>& fields);

// Changes, adds, removes, repeats or swaps a field of the message, at any depth, and makes all lengths fit again. Bytes that are not a
// message get a plain change of bytes.
Bytes mutate_proto(const Bytes& message, Mutation& mutation, int depth = 0);

}  // namespace hapton::fuzz
