#pragma once

#include <string>
#include <string_view>

#include "vrpn/vrpn_wire.h"

namespace hapton::vrpn {

// The bytes of a text such as "00 2a"; spaces and line ends have no meaning.
inline Bytes hex(std::string_view text) {
  Bytes bytes;
  int high_digit = -1;
  for (const char letter : text) {
    if (letter == ' ' || letter == '\n') continue;
    const int value = letter <= '9' ? letter - '0' : letter - 'a' + 10;
    if (high_digit < 0) {
      high_digit = value;
    } else {
      bytes.push_back(static_cast<std::byte>(16 * high_digit + value));
      high_digit = -1;
    }
  }
  return bytes;
}

inline std::string to_hex(std::span<const std::byte> bytes) {
  std::string text;
  for (std::size_t n = 0; n < bytes.size(); ++n) {
    constexpr std::string_view kDigits = "0123456789abcdef";
    const auto value = std::to_integer<unsigned>(bytes[n]);
    text += kDigits[value / 16];
    text += kDigits[value % 16];
    text += n % 8 == 7 ? '\n' : ' ';
  }
  return text;
}

}  // namespace hapton::vrpn
