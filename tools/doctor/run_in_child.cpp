#include "tools/doctor/run_in_child.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <string_view>
#include <thread>

namespace hapton::doctor {
namespace {

constexpr auto kPollPeriod = std::chrono::milliseconds(2);  // between two checks whether the child has ended; a free choice

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(file, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::string read_all(int file) {
  std::string text;
  char block[4096];
  ::lseek(file, 0, SEEK_SET);
  for (ssize_t count = ::read(file, block, sizeof block); count > 0; count = ::read(file, block, sizeof block)) {
    text.append(block, static_cast<std::size_t>(count));
  }
  return text;
}

// The child: runs the task without input and output, and writes its result to the file.
[[noreturn]] void reply(const std::function<std::string()>& task, int file) {
  const int null_device = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null_device, standard);
  ::_exit(write_all(file, task()) ? 0 : 1);
}

// How the child failed; empty: it ended without an error.
std::string wait_for(pid_t child, double timeout_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  int status = 0;
  while (::waitpid(child, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) {
      ::kill(child, SIGKILL);
      ::waitpid(child, &status, 0);
      return fmt::format("it did not come back within {:g} s", timeout_s);
    }
    std::this_thread::sleep_for(kPollPeriod);
  }
  if (WIFSIGNALED(status)) return fmt::format("it ended the process with signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  return WEXITSTATUS(status) == 0 ? "" : fmt::format("it ended the process with exit code {}", WEXITSTATUS(status));
}

}  // namespace

ChildReply run_in_child(const std::function<std::string()>& task, double timeout_s) {
  const int file = ::memfd_create("reply", MFD_CLOEXEC);
  if (file < 0) return {{}, fmt::format("the check could not run: {}", std::strerror(errno))};
  const pid_t child = ::fork();
  if (child == 0) reply(task, file);
  ChildReply result;
  if (child < 0) {
    result.failure = fmt::format("the check could not run: {}", std::strerror(errno));
  } else {
    result.failure = wait_for(child, timeout_s);
    if (result.failure.empty()) result.text = read_all(file);
  }
  ::close(file);
  return result;
}

}  // namespace hapton::doctor
