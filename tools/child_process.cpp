#include "tools/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include "runtime/clock.h"

namespace hapton {
namespace {

// The list of file actions of posix_spawn. The destructor frees it on every return.
class SpawnActions {
 public:
  SpawnActions() { posix_spawn_file_actions_init(&actions_); }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;

  int run_in(const std::filesystem::path& folder) { return posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str()); }
  int write_to(const std::filesystem::path& file) {
    const int open_error = posix_spawn_file_actions_addopen(&actions_, STDOUT_FILENO, file.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    return open_error != 0 ? open_error : posix_spawn_file_actions_adddup2(&actions_, STDOUT_FILENO, STDERR_FILENO);
  }
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_ = {};
};

int to_exit_code(int status) { return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status); }

}  // namespace

Result<ChildProcess> ChildProcess::start(const ChildCommand& command) {
  std::vector<std::string> words = {command.program.string()};
  words.insert(words.end(), command.arguments.begin(), command.arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);

  SpawnActions actions;
  // The output's path may be relative to the folder of this process, so the child opens the output before it changes its folder.
  int error = command.output.empty() ? 0 : actions.write_to(command.output);
  if (error == 0 && !command.folder.empty()) {
    error = actions.run_in(command.folder);
  }
  pid_t pid = -1;
  if (error == 0) {
    error = posix_spawnp(&pid, words[0].c_str(), actions.get(), nullptr, argv.data(), environ);
  }
  if (error != 0) {
    return fail("{} cannot be started: {}", words[0], std::strerror(error));
  }
  return ChildProcess(pid);
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept : pid_(std::exchange(other.pid_, -1)), exit_code_(other.exit_code_) {}

ChildProcess::~ChildProcess() {
  if (pid_ > 0) {
    stop();
  }
}

std::optional<int> ChildProcess::wait(double seconds) {
  constexpr std::int64_t kChildPollNs = 5 * kNanosecondsPerMillisecond;  // between two checks whether the child has ended; a free choice
  SteadyClock clock;
  const double end_ns = static_cast<double>(clock.now_ns()) + 1e9 * seconds;
  while (!exit_code_ && pid_ > 0) {
    int status = 0;
    const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
    if (ended == pid_ || (ended < 0 && errno != EINTR)) {
      exit_code_ = ended == pid_ ? to_exit_code(status) : 1;
      pid_ = -1;
    } else if (static_cast<double>(clock.now_ns()) >= end_ns) {
      return std::nullopt;
    } else {
      clock.sleep_until_ns(clock.now_ns() + kChildPollNs);
    }
  }
  return exit_code_;
}

void ChildProcess::kill() {
  if (exit_code_ || pid_ <= 0) return;     // a moved-from object has the pid -1, and a signal to -1 goes to every process
  constexpr double kKilledTimeoutS = 5.0;  // a killed process ends at once, unless a system call holds it; a free choice
  ::kill(pid_, SIGKILL);
  wait(kKilledTimeoutS);
}

int ChildProcess::stop(double seconds) {
  if (!exit_code_ && pid_ > 0) {
    ::kill(pid_, SIGTERM);
    if (!wait(seconds)) kill();
  }
  return exit_code_.value_or(128 + SIGKILL);
}

std::filesystem::path find_own_folder() {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? std::filesystem::path(".") : self.parent_path();
}

}  // namespace hapton
