#include "link/marker_text.h"

#include <cstdint>

namespace hapton {
namespace {

// Removes the first character of a text that is not empty. False: it is not UTF-8.
bool take_character(std::string_view& text, std::uint32_t& character) noexcept {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t length = first < 0x80 ? 1 : (first & 0xE0) == 0xC0 ? 2 : (first & 0xF0) == 0xE0 ? 3 : (first & 0xF8) == 0xF0 ? 4 : 0;
  if (length == 0 || text.size() < length) return false;
  character = length == 1 ? first : first & (0x7FU >> length);
  for (std::size_t i = 1; i < length; ++i) {
    const auto next = static_cast<unsigned char>(text[i]);
    if ((next & 0xC0) != 0x80) return false;
    character = character << 6 | (next & 0x3FU);
  }
  constexpr std::uint32_t kMin[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = character >= 0xD800 && character <= 0xDFFF;
  if (character < kMin[length] || is_surrogate || character > 0x10FFFF) return false;
  text.remove_prefix(length);
  return true;
}

bool is_shown(std::uint32_t c) noexcept { return c >= 0x20 && !(c >= 0x7F && c <= 0x9F) && c != 0x2028 && c != 0x2029; }

}  // namespace

bool MarkerText::is_valid(std::string_view text) noexcept {
  if (text.empty() || text.size() > kMaxBytes) return false;
  while (!text.empty()) {
    std::uint32_t character = 0;
    if (!take_character(text, character) || !is_shown(character)) return false;
  }
  return true;
}

}  // namespace hapton
