#include "tests/support/system_call_guard.h"

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstddef>

#if defined(__has_feature)
#define HAPTON_CLANG_SANITIZER(name) __has_feature(name)
#else
#define HAPTON_CLANG_SANITIZER(name) 0
#endif

namespace hapton {
namespace {

// The number of the forbidden call; below 0: none was made. In memory shared with the parent process.
volatile int* stopped_call = nullptr;

void note_call(int, siginfo_t* info, void*) {
  *stopped_call = info->si_syscall;
  _exit(3);
}

bool forbid_calls() {
  struct sigaction action = {};
  action.sa_sigaction = note_call;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGSYS, &action, nullptr);
  sock_filter rules[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_exit_group, 1, 0),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_clock_gettime, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_TRAP),
  };
  sock_fprog program = {.len = sizeof rules / sizeof rules[0], .filter = rules};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
}

}  // namespace

std::string SystemCallGuard::run(const std::function<void()>& prepare, const std::function<void()>& work) {
  void* shared = mmap(nullptr, sizeof(int), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  stopped_call = static_cast<volatile int*>(shared);
  *stopped_call = -1;
  const pid_t child = fork();
  if (child == 0) {
    prepare();
    if (!forbid_calls()) _exit(2);
    work();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  const int call = *stopped_call;
  munmap(shared, sizeof(int));
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
  if (WIFEXITED(status) && WEXITSTATUS(status) == 2) return "the filter could not be set";
  if (call >= 0) return "system call " + std::to_string(call);
  return "ended with status " + std::to_string(status);
}

bool SystemCallGuard::is_available() {
#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__) || HAPTON_CLANG_SANITIZER(thread_sanitizer) || \
    HAPTON_CLANG_SANITIZER(address_sanitizer)
  return false;
#else
  return run([] {}, [] {}).empty();
#endif
}

}  // namespace hapton
