#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace hapton {

// Reads text word by word and counts its lines. Carriage returns count as blanks. RT: set-up only.
class TextCursor {
 public:
  explicit TextCursor(std::string_view text, std::size_t first_line = 1)
      : at_(text.data()), end_(text.data() + text.size()), line_(first_line) {}

  bool at_end() const { return at_ == end_; }
  std::size_t line() const { return line_; }
  std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - at_); }

  // The next word in this line; empty at the end of the line. A backslash at the end of a line joins the next line to it.
  std::string_view word_in_line();
  // The next word of the text, in this line or a later one; empty at the end of the text.
  std::string_view word();
  // The rest of this line, without leading and trailing blanks.
  std::string_view rest_of_line();
  void next_line();

 private:
  std::string_view take_word();

  const char* at_;
  const char* end_;
  std::size_t line_;
};

// Reads the whole word as a number, with a decimal point in every locale. False if it is not a number; values too small for a double become
// zero, too large ones infinite.
bool parse_number(std::string_view word, double& value);
bool parse_integer(std::string_view word, std::int64_t& value);

// The text without the byte order mark that some Windows programs write before UTF-8.
std::string_view without_byte_order_mark(std::string_view text);

constexpr std::size_t kLongestShownName = 200;

// A word for a message: its first `longest` bytes (by default 40), with "?" for characters that are not printable, and "..." if it was
// longer.
std::string printable(std::string_view word, std::size_t longest);
std::string printable(std::string_view word);

}  // namespace hapton
