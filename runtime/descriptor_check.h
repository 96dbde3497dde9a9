#pragma once

#include <cstdint>

namespace hapton {

// How many file descriptors this process may have (ulimit -n), and how many it has. Unlimited where the system does not tell. RT: set-up
// only. Threads: any.
struct DescriptorRoom {
  std::uint64_t allowed = 0;
  std::uint64_t in_use = 0;

  std::uint64_t left() const { return allowed > in_use ? allowed - in_use : 0; }
};
DescriptorRoom find_descriptor_room();

// What each of Hapton's programs may open before it runs: sockets, timers, meshes one after another, libraries, a window. A round number
// above that; with fewer, a program would start and fail later.
constexpr std::uint64_t kDescriptorsNeeded = 32;

// If fewer than kDescriptorsNeeded are left: prints one line with the remedy and exits with 1, rather than fail wherever the last
// descriptor is needed. The nodes and `hapton` call it at the beginning of main(). RT: set-up only.
void check_descriptors(const char* program);

}  // namespace hapton
