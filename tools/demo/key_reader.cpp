#include "tools/demo/key_reader.h"

#include <unistd.h>

#include "runtime/clock.h"

namespace hapton {

KeyReader::KeyReader() {
  termios settings = {};
  if (::isatty(STDIN_FILENO) != 1 || ::tcgetattr(STDIN_FILENO, &settings) != 0) return;
  original_settings_ = settings;
  settings.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  settings.c_cc[VMIN] = 0;
  settings.c_cc[VTIME] = 1;  // tenths of a second
  ::tcsetattr(STDIN_FILENO, TCSANOW, &settings);
}

KeyReader::~KeyReader() {
  if (original_settings_) ::tcsetattr(STDIN_FILENO, TCSANOW, &*original_settings_);
}

std::optional<char> KeyReader::read_key() {
  char key = 0;
  if (is_terminal()) return ::read(STDIN_FILENO, &key, 1) == 1 ? std::optional(key) : std::nullopt;
  SteadyClock clock;
  clock.sleep_until_ns(clock.now_ns() + 100 * kNanosecondsPerMillisecond);
  return std::nullopt;
}

}  // namespace hapton
