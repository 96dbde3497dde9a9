#include "link/message_payload.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <variant>

#include "link/messages.h"

namespace hapton {

std::string_view find_message_payload(std::span<const std::byte> envelope) noexcept {
  using google::protobuf::internal::WireFormatLite;
  // Fields with smaller numbers are the header; larger numbers are messages that only later builds know.
  constexpr int kFirstMessage = 16;
  constexpr int kLastMessage = kFirstMessage + static_cast<int>(std::variant_size_v<Message>) - 1;
  const std::string_view bytes(reinterpret_cast<const char*>(envelope.data()), envelope.size());
  google::protobuf::io::CodedInputStream input(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size()));
  while (const std::uint32_t tag = input.ReadTag()) {
    const int field = WireFormatLite::GetTagFieldNumber(tag);
    const bool is_message =
        field >= kFirstMessage && field <= kLastMessage && WireFormatLite::GetTagWireType(tag) == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
    if (!is_message) {
      if (!WireFormatLite::SkipField(&input, tag)) return {};
      continue;
    }
    std::uint32_t length = 0;
    if (!input.ReadVarint32(&length)) return {};
    const auto begin = static_cast<std::size_t>(input.CurrentPosition());
    return length <= bytes.size() - begin ? bytes.substr(begin, length) : std::string_view();
  }
  return {};
}

}  // namespace hapton
