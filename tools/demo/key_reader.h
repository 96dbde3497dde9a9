#pragma once

#include <termios.h>

#include <optional>

namespace hapton {

// Reads keys as they are typed, without Enter and without echo, while it lives. If stdin is not a terminal there are none. RT: no. Threads:
// one.
class KeyReader {
 public:
  KeyReader();
  ~KeyReader();
  KeyReader(const KeyReader&) = delete;
  KeyReader& operator=(const KeyReader&) = delete;

  bool is_terminal() const { return before_.has_value(); }

  // Waits a tenth of a second at most.
  std::optional<char> read_key();

 private:
  std::optional<termios> before_;
};

}  // namespace hapton
