#pragma once

#include <cstdint>

namespace hapton {

// How many file descriptors this process may have open (ulimit -n), and how many it has open. If the system does not report the limit, none
// is assumed; if it does not report the open descriptors, they count as 0. RT: set-up only. Threads: any.
struct DescriptorRoom {
  std::uint64_t allowed = 0;
  std::uint64_t in_use = 0;

  std::uint64_t left() const { return allowed > in_use ? allowed - in_use : 0; }
};
DescriptorRoom find_descriptor_room();

// The most descriptors that any of Hapton's programs opens while it starts (sockets, timers, one mesh file at a time, libraries, a window),
// rounded up. With fewer left, a program would start and fail later.
constexpr std::uint64_t kDescriptorsNeeded = 32;

// If fewer than kDescriptorsNeeded are left: prints one line with the remedy and exits with 1, so that the program does not fail later,
// wherever it finds no descriptor left. The nodes and `hapton` call it at the beginning of main(). RT: set-up only.
void check_descriptors(const char* program);

}  // namespace hapton
