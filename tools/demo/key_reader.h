#pragma once

#include <termios.h>

#include <optional>

namespace hapton {

// Reads keys from stdin as they are typed, without Enter and without echo, for as long as this object lives. If stdin is not a terminal,
// there are no keys. RT: no. Threads: one.
class KeyReader {
 public:
  KeyReader();
  ~KeyReader();
  KeyReader(const KeyReader&) = delete;
  KeyReader& operator=(const KeyReader&) = delete;

  bool is_terminal() const { return original_settings_.has_value(); }

  // Waits for a key, 0.1 s at most; none: no key was typed.
  std::optional<char> read_key();

 private:
  std::optional<termios> original_settings_;
};

}  // namespace hapton
