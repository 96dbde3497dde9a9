#include "tests/fuzz/session_mutator.h"

#include <boost/crc.hpp>

#include "link/session_codec.h"
#include "tests/fuzz/proto_mutator.h"

namespace hapton::fuzz {
namespace {

constexpr std::size_t kCheckBytes = 5;  // as proto/session.proto defines: the field's tag and a CRC-32
constexpr std::uint8_t kCheckTag = 0x7D;

std::size_t take_length(std::span<const std::uint8_t>& rest) {
  std::size_t length = 0;
  for (int shift = 0; shift < 35 && !rest.empty(); shift += 7) {
    const std::uint8_t byte = rest[0];
    rest = rest.subspan(1);
    length |= static_cast<std::size_t>(byte & 0x7F) << shift;
    if (byte < 0x80) break;
  }
  return length;
}

void append_message(const Bytes& message, Bytes& to) {
  std::size_t length = message.size() + kCheckBytes;
  for (; length >= 0x80; length >>= 7) to.push_back(static_cast<std::uint8_t>(length | 0x80));
  to.push_back(static_cast<std::uint8_t>(length));
  to.insert(to.end(), message.begin(), message.end());
  boost::crc_32_type crc;
  crc.process_bytes(message.data(), message.size());
  to.push_back(kCheckTag);
  for (int shift = 0; shift < 32; shift += 8) to.push_back(static_cast<std::uint8_t>(crc.checksum() >> shift));
}

}  // namespace

std::optional<std::vector<Bytes>> split_session(std::span<const std::uint8_t> file) {
  if (file.size() < kSessionMagic.size() || !std::equal(kSessionMagic.begin(), kSessionMagic.end(), file.begin())) return std::nullopt;
  std::vector<Bytes> messages;
  for (auto rest = file.subspan(kSessionMagic.size()); !rest.empty();) {
    const std::size_t length = take_length(rest);
    if (length < kCheckBytes || length > rest.size()) break;
    messages.emplace_back(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(length - kCheckBytes));
    rest = rest.subspan(length);
  }
  return messages;
}

Bytes join_session(const std::vector<Bytes>& messages) {
  Bytes file(kSessionMagic.begin(), kSessionMagic.end());
  for (const Bytes& message : messages) append_message(message, file);
  return file;
}

Bytes mutate_session(std::span<const std::uint8_t> file, Mutation& mutation) {
  auto messages = split_session(file);
  if (!messages || messages->empty()) return mutation.change(Bytes(file.begin(), file.end()), mutation.max_size());
  if (mutation.one_in(4)) {
    mutation.change_order(*messages);
  } else {
    Bytes& message = (*messages)[mutation.below(messages->size())];
    message = mutate_proto(message, mutation);
  }
  return join_session(*messages);
}

Bytes cross_sessions(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b, Mutation& mutation) {
  return join_session(mutation.cross(split_session(a).value_or(std::vector<Bytes>()), split_session(b).value_or(std::vector<Bytes>())));
}

}  // namespace hapton::fuzz
