#pragma once

#include <functional>
#include <string>

namespace hapton {

// Proves that code makes no system calls. RT: no.
class SystemCallGuard {
 public:
  // Runs `prepare` and then `work` in a process of its own; during `work` the first system call ends that process. Allowed are exit and
  // clock_gettime, which a kernel whose clock has no vdso needs. Returns what happened: empty if `work` came to its end.
  static std::string run(const std::function<void()>& prepare, const std::function<void()>& work);

  // False where the guard cannot work: sanitizers make system calls of their own, and some kernels have no seccomp.
  static bool is_available();
};

}  // namespace hapton
