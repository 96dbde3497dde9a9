#include "scene/text_cursor.h"

#include <algorithm>
#include <charconv>
#include <clocale>
#include <cstdlib>
#include <cstring>
#include <string>

namespace hapton {
namespace {

// Length in bytes of the first character, in UTF-8 (RFC 3629). 0: it is invalid or not printable: a control character, a line or paragraph
// separator, a formatting character such as a change of the writing direction. Pre: not empty.
std::size_t visible_length(std::string_view text) {
  const auto byte = [&](std::size_t n) { return static_cast<unsigned char>(text[n]); };
  if (byte(0) < 0x80) return byte(0) >= ' ' && byte(0) <= '~' ? 1 : 0;
  const std::size_t length = byte(0) >= 0xF0 ? 4 : byte(0) >= 0xE0 ? 3 : byte(0) >= 0xC0 ? 2 : 0;
  if (length == 0 || text.size() < length) return 0;
  char32_t code = byte(0) & (0x7FU >> length);
  for (std::size_t n = 1; n < length; ++n) {
    if ((byte(n) & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (byte(n) & 0x3FU);
  }
  constexpr char32_t kMin[] = {0, 0, 0xA0, 0x800, 0x10000};
  if (code < kMin[length] || code > 0x10FFFF || (code >= 0xD800 && code <= 0xDFFF)) return 0;
  const bool is_format = (code >= 0x200B && code <= 0x200F) || (code >= 0x2028 && code <= 0x202E) || (code >= 0x2060 && code <= 0x206F) ||
                         code == 0x61C || code == 0xAD || code == 0xFEFF;
  return is_format ? 0 : length;
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

std::string_view without_plus(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+';
  return plus ? word.substr(1) : word;
}

// For a number that no double can hold: strtod returns infinity or about zero. It uses the "C" locale, as files do, not the program's.
double too_small_or_too_large(std::string_view word) {
  static locale_t const kPlain = newlocale(LC_ALL_MASK, "C", nullptr);
  return strtod_l(std::string(word).c_str(), nullptr, kPlain);
}

}  // namespace

std::string_view TextCursor::take_word() {
  const char* start = at_;
  while (at_ != end_ && *at_ != '\n' && !is_blank(*at_)) ++at_;
  return {start, static_cast<std::size_t>(at_ - start)};
}

std::string_view TextCursor::word_in_line() {
  while (at_ != end_) {
    if (is_blank(*at_)) {
      ++at_;
    } else if (*at_ == '\\') {
      const char* after = at_ + 1;
      if (after != end_ && *after == '\r') ++after;
      if (after == end_ || *after != '\n') break;
      at_ = after + 1;
      ++line_;
    } else {
      break;
    }
  }
  return take_word();
}

std::string_view TextCursor::word() {
  while (at_ != end_ && (*at_ == '\n' || is_blank(*at_))) {
    if (*at_ == '\n') ++line_;
    ++at_;
  }
  return take_word();
}

std::string_view TextCursor::rest_of_line() {
  while (at_ != end_ && is_blank(*at_)) ++at_;
  const char* start = at_;
  while (at_ != end_ && *at_ != '\n') ++at_;
  const char* last = at_;
  while (last != start && is_blank(last[-1])) --last;
  return {start, static_cast<std::size_t>(last - start)};
}

void TextCursor::next_line() {
  const void* found = at_ == end_ ? nullptr : std::memchr(at_, '\n', bytes_left());
  if (found == nullptr) {
    at_ = end_;
    return;
  }
  at_ = static_cast<const char*>(found) + 1;
  ++line_;
}

bool parse_number(std::string_view word, double& value) {
  word = without_plus(word);
  const auto [after, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (after != word.data() + word.size() || word.empty()) return false;
  if (error == std::errc::result_out_of_range) value = too_small_or_too_large(word);
  return error == std::errc() || error == std::errc::result_out_of_range;
}

bool parse_integer(std::string_view word, std::int64_t& value) {
  word = without_plus(word);
  const auto [after, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && after == word.data() + word.size();
}

std::string_view without_byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

std::string printable(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  return printable(word, kLongest);
}

std::string printable(std::string_view word, std::size_t longest) {
  std::string shown;
  for (std::string_view left = word; !left.empty();) {
    const std::size_t length = visible_length(left);
    if (shown.size() + std::max<std::size_t>(length, 1) > longest) return shown + "...";
    shown += length == 0 ? std::string_view("?") : left.substr(0, length);
    left.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return shown;
}

}  // namespace hapton
