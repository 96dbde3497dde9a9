#include "tests/fuzz/proto_mutator.h"

#include <cstring>

namespace hapton::fuzz {
namespace {

using Type = ProtoField::Type;

constexpr int kMaxDepth = 4;
constexpr std::size_t kMaxGrowth = 256;

std::optional<std::uint64_t> take_varint(std::span<const std::uint8_t>& rest) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64 && !rest.empty(); shift += 7) {
    const std::uint8_t byte = rest[0];
    rest = rest.subspan(1);
    value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
    if (byte < 0x80) return value;
  }
  return std::nullopt;
}

void append_varint(std::uint64_t value, Bytes& to) {
  for (; value >= 0x80; value >>= 7) to.push_back(static_cast<std::uint8_t>(value | 0x80));
  to.push_back(static_cast<std::uint8_t>(value));
}

bool take_fixed(std::span<const std::uint8_t>& rest, std::size_t size, std::uint64_t& value) {
  if (rest.size() < size) return false;
  std::memcpy(&value, rest.data(), size);
  rest = rest.subspan(size);
  return true;
}

bool take_bytes(std::span<const std::uint8_t>& rest, Bytes& bytes) {
  const auto length = take_varint(rest);
  if (!length || *length > rest.size()) return false;
  bytes.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(*length));
  rest = rest.subspan(*length);
  return true;
}

bool take_field(std::span<const std::uint8_t>& rest, ProtoField& field) {
  const auto tag = take_varint(rest);
  if (!tag || *tag >> 3 == 0 || *tag >> 3 > 0x1FFFFFFF) return false;
  field.number = static_cast<std::uint32_t>(*tag >> 3);
  field.type = static_cast<Type>(*tag & 7);
  switch (field.type) {
    case Type::varint: {
      const auto value = take_varint(rest);
      field.value = value.value_or(0);
      return value.has_value();
    }
    case Type::fixed64:
      return take_fixed(rest, 8, field.value);
    case Type::fixed32:
      return take_fixed(rest, 4, field.value);
    case Type::bytes:
      return take_bytes(rest, field.bytes);
  }
  return false;  // groups are not supported
}

void append_fixed(std::uint64_t value, std::size_t size, Bytes& to) {
  for (; size > 0; --size, value >>= 8) to.push_back(static_cast<std::uint8_t>(value));
}

void change_packed_double(Bytes& packed, Mutation& mutation) {
  const std::uint64_t bits = mutation.odd_double_bits();
  std::memcpy(packed.data() + 8 * mutation.below(packed.size() / 8), &bits, sizeof bits);
}

void change_field(ProtoField& field, Mutation& mutation, int depth) {
  if (field.type != Type::bytes) {
    field.value = mutation.one_in(3)                                  ? field.value + mutation.below(5) - 2
                  : field.type == Type::fixed64 && mutation.one_in(2) ? mutation.odd_double_bits()
                                                                      : mutation.odd_number();
    return;
  }
  if (field.bytes.size() >= 8 && field.bytes.size() % 8 == 0 && mutation.one_in(2)) return change_packed_double(field.bytes, mutation);
  if (depth < kMaxDepth && !field.bytes.empty() && !mutation.one_in(8)) {
    field.bytes = mutate_proto(field.bytes, mutation, depth + 1);
  } else {
    field.bytes = mutation.change(std::move(field.bytes), field.bytes.size() + kMaxGrowth);
  }
}

ProtoField make_field(Mutation& mutation) {
  constexpr Type kTypes[] = {Type::varint, Type::fixed64, Type::bytes, Type::fixed32};
  ProtoField field;
  field.number = static_cast<std::uint32_t>(1 + mutation.below(32));
  field.type = kTypes[mutation.below(std::size(kTypes))];
  field.value = mutation.odd_number();
  if (field.type == Type::bytes) field.bytes = Bytes(mutation.below(33), static_cast<std::uint8_t>(mutation.below(256)));
  return field;
}

}  // namespace

std::optional<std::vector<ProtoField>> split_proto(std::span<const std::uint8_t> message) {
  std::vector<ProtoField> fields;
  while (!message.empty()) {
    if (!take_field(message, fields.emplace_back())) return std::nullopt;
  }
  return fields;
}

Bytes join_proto(const std::vector<ProtoField>& fields) {
  Bytes message;
  for (const ProtoField& field : fields) {
    append_varint(std::uint64_t{field.number} << 3 | static_cast<std::uint64_t>(field.type), message);
    switch (field.type) {
      case Type::varint:
        append_varint(field.value, message);
        break;
      case Type::fixed64:
        append_fixed(field.value, 8, message);
        break;
      case Type::fixed32:
        append_fixed(field.value, 4, message);
        break;
      case Type::bytes:
        append_varint(field.bytes.size(), message);
        message.insert(message.end(), field.bytes.begin(), field.bytes.end());
    }
  }
  return message;
}

Bytes mutate_proto(const Bytes& message, Mutation& mutation, int depth) {
  auto fields = split_proto(message);
  if (!fields || fields->empty()) return mutation.change(message, message.size() + kMaxGrowth);
  switch (mutation.below(8)) {
    case 0:
      mutation.change_order(*fields);
      break;
    case 1:
      fields->insert(fields->begin() + static_cast<std::ptrdiff_t>(mutation.below(fields->size() + 1)), make_field(mutation));
      break;
    default:
      change_field((*fields)[mutation.below(fields->size())], mutation, depth);
  }
  return join_proto(*fields);
}

}  // namespace hapton::fuzz
