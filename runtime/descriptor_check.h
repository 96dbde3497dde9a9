#pragma once

#include <cstdint>

namespace hapton {

// How many file descriptors a process may have (ulimit -n), and how many it has. RT: set-up only.
struct DescriptorRoom {
  std::uint64_t allowed = 0;
  std::uint64_t in_use = 0;

  std::uint64_t left() const { return allowed > in_use ? allowed - in_use : 0; }
};
DescriptorRoom find_descriptor_room();

// What each of our programs may open before it runs: sockets, timers, meshes one after another, libraries, a window.
constexpr std::uint64_t kDescriptorsNeeded = 32;

// Second line of every main: when there is less room than that, prints one line and exits 1, rather than fail at whatever comes to need
// the last descriptor. RT: set-up only.
void check_descriptors(const char* program);

}  // namespace hapton
