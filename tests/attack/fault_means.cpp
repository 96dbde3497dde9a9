#include "tests/attack/fault_means.h"

#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace hapton::attack {

StoppedThread::StoppedThread(pid_t thread) : thread_(thread) {
  if (::ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) != 0) return;
  // The stop takes effect soon and is not waited for here.
  is_stopped_ = ::ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr) == 0;
}

StoppedThread::~StoppedThread() {
  if (!is_stopped_) return;
  int status = 0;
  ::waitpid(thread_, &status, __WALL);
  ::ptrace(PTRACE_DETACH, thread_, nullptr, nullptr);
}

std::optional<pid_t> find_thread(pid_t process, const std::string& name) {
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", error)) {
    std::string comm;
    std::getline(std::ifstream(entry.path() / "comm"), comm);
    if (comm == name) return std::stoi(entry.path().filename().string());
  }
  return std::nullopt;
}

std::vector<pid_t> find_children(pid_t process) {
  std::vector<pid_t> children;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", error)) {
    std::ifstream file(entry.path() / "children");
    for (pid_t child = 0; file >> child;) children.push_back(child);
  }
  return children;
}

RealtimeHog::RealtimeHog() {
  cpu_set_t allowed;
  if (::sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  for (int cpu = 0; cpu < CPU_SETSIZE; ++cpu) {
    if (!CPU_ISSET(cpu, &allowed)) continue;
    const pid_t child = ::fork();
    if (child < 0) return;
    if (child > 0) {
      children_.push_back(child);
      continue;
    }
    // The child must not outlive its parent.
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::alarm(30);
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(cpu, &one);
    const sched_param requested = {.sched_priority = kPriority};
    if (::sched_setaffinity(0, sizeof one, &one) != 0 || ::sched_setscheduler(0, SCHED_FIFO, &requested) != 0) ::_exit(1);
    for (;;) {
      asm volatile("");
    }
  }
  // A child whose request was denied has ended.
  ::usleep(50'000);
  std::erase_if(children_, [](pid_t child) { return ::waitpid(child, nullptr, WNOHANG) == child; });
}

RealtimeHog::~RealtimeHog() {
  for (const pid_t child : children_) {
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
}

}  // namespace hapton::attack
