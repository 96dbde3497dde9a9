#pragma once

#include <cstddef>
#include <filesystem>
#include <iterator>

namespace hapton {

// How many files, sockets and timers the process has open. Nodes run for days: what they open repeatedly they must also close.
inline std::size_t count_open_files() {
  return static_cast<std::size_t>(
      std::distance(std::filesystem::directory_iterator("/proc/self/fd"), std::filesystem::directory_iterator()));
}

// Whether many calls leave files open: at least one for every ten calls, as other threads may open a few files meanwhile.
template <class Action>
bool leaves_files_open(Action&& action) {
  constexpr std::size_t kCalls = 50;
  const std::size_t before = count_open_files();
  for (std::size_t n = 0; n < kCalls; ++n) action();
  return count_open_files() >= before + kCalls / 10;
}

}  // namespace hapton
