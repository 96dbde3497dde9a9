#include "scene/text_cursor.h"

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <string>

namespace hapton {
namespace {

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

std::string_view without_plus(std::string_view word) {
  const bool plus = word.size() > 1 && word[0] == '+' && word[1] != '-' && word[1] != '+';
  return plus ? word.substr(1) : word;
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
  if (error == std::errc::result_out_of_range) value = std::strtod(std::string(word).c_str(), nullptr);
  return error == std::errc() || error == std::errc::result_out_of_range;
}

bool parse_integer(std::string_view word, std::int64_t& value) {
  word = without_plus(word);
  const auto [after, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && after == word.data() + word.size();
}

std::string printable(std::string_view word) {
  constexpr std::size_t kLongest = 40;
  std::string shown;
  for (const char c : word.substr(0, kLongest)) shown += c >= ' ' && c <= '~' ? c : '?';
  return word.size() > kLongest ? shown + "..." : shown;
}

}  // namespace hapton
