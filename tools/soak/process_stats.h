#pragma once

#include <sys/types.h>

#include <cstdint>

#include "core/base/result.h"

namespace hapton {

// Resources of a running process.
struct ProcessStats {
  std::int64_t resident_kib = 0;
  int descriptors = 0;
  int threads = 0;
};

// Reads them from /proc/PID. RT: no. Error: one line: there is no such process, or no permission.
Result<ProcessStats> read_process_stats(pid_t pid);

}  // namespace hapton
