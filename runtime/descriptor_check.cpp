#include "runtime/descriptor_check.h"

#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <system_error>

namespace hapton {

DescriptorRoom find_descriptor_room() {
  rlimit limit = {};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return {.allowed = std::numeric_limits<std::uint64_t>::max()};
  DescriptorRoom room{.allowed = limit.rlim_cur};
  std::error_code error;
  std::filesystem::directory_iterator open_ones("/proc/self/fd", error);
  // The check itself needs a descriptor. If none is free, all are in use. Without /proc the number is unknown.
  if (error == std::errc::too_many_files_open) return {.allowed = room.allowed, .in_use = room.allowed};
  for (; !error && open_ones != std::filesystem::directory_iterator(); open_ones.increment(error)) ++room.in_use;
  if (room.in_use > 0) --room.in_use;  // the descriptor with which they are listed
  return room;
}

void check_descriptors(const char* program) {
  const DescriptorRoom room = find_descriptor_room();
  if (room.left() >= kDescriptorsNeeded) return;
  std::fprintf(
      stderr,
      "%s: only %llu file descriptors are allowed and %llu of them in use, which leaves fewer than the %llu that it needs; allow more "
      "with: ulimit -n 1024 (of a service: LimitNOFILE=1024)\n",
      program, static_cast<unsigned long long>(room.allowed), static_cast<unsigned long long>(room.in_use),
      static_cast<unsigned long long>(kDescriptorsNeeded));
  std::exit(1);
}

}  // namespace hapton
