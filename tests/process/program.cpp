#include "tests/process/program.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <fstream>
#include <sstream>
#include <string_view>
#include <thread>

extern char** environ;

namespace hapton::process {
namespace {

constexpr Seconds kPoll = Seconds(0.005);

int open_local_port(int& port) {
  const int descriptor = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  if (::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), size) != 0) ADD_FAILURE() << "no free UDP port on 127.0.0.1";
  ::getsockname(descriptor, reinterpret_cast<sockaddr*>(&address), &size);
  port = ntohs(address.sin_port);
  return descriptor;
}

std::vector<char*> environment_without(const std::vector<std::string_view>& names) {
  std::vector<char*> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view name = std::string_view(*variable).substr(0, std::string_view(*variable).find('='));
    if (std::ranges::find(names, name) == names.end()) variables.push_back(*variable);
  }
  return variables;
}

}  // namespace

Program::Program(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                 const std::string& display) {
  static std::atomic<int> started = 0;
  const std::string stem = std::filesystem::path(name).filename().string() + "." + std::to_string(++started);
  out_path_ = folder / (stem + ".out");
  err_path_ = folder / (stem + ".err");

  std::string path = (std::filesystem::path(HAPTON_BIN_DIR) / name).string();
  std::vector<std::string> words = arguments;
  std::vector<char*> argv = {path.data()};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  std::string display_variable = "DISPLAY=" + display;
  std::string runtime_variable = "XDG_RUNTIME_DIR=" + folder.string();
  std::vector<char*> environment = environment_without({"DISPLAY", "XDG_RUNTIME_DIR"});
  environment.push_back(runtime_variable.data());
  if (!display.empty()) environment.push_back(display_variable.data());
  environment.push_back(nullptr);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err_path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  const int failure = ::posix_spawn(&pid_, path.c_str(), &actions, nullptr, argv.data(), environment.data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure != 0) {
    ADD_FAILURE() << "cannot start " << path << ": " << std::strerror(failure);
    pid_ = -1;
    status_ = -1;
  }
}

Program::~Program() { kill(); }

void Program::collect(bool block) {
  if (status_) return;
  int status = 0;
  if (::waitpid(pid_, &status, block ? 0 : WNOHANG) == pid_) status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool Program::is_running() {
  collect(false);
  return !status_;
}

void Program::send_signal(int signal) {
  if (is_running()) ::kill(pid_, signal);
}

void Program::kill() {
  send_signal(SIGKILL);
  collect(true);
}

std::optional<Ended> Program::wait(Seconds at_most) {
  const auto deadline = std::chrono::steady_clock::now() + at_most;
  while (is_running() && std::chrono::steady_clock::now() < deadline) std::this_thread::sleep_for(kPoll);
  if (is_running()) return std::nullopt;
  return Ended{*status_, out(), err()};
}

std::string Program::out() const { return read_text(out_path_); }
std::string Program::err() const { return read_text(err_path_); }

std::optional<Ended> run(const std::string& name, const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                         Seconds at_most) {
  return Program(name, arguments, folder).wait(at_most);
}

VirtualDisplay::VirtualDisplay() {
  int ends[2] = {-1, -1};
  if (::pipe2(ends, O_CLOEXEC) != 0) return;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, ends[1], 3);
  std::vector<std::string> words = {"Xvfb", "-displayfd", "3", "-screen", "0", "1280x720x24", "-nolisten", "tcp", "-noreset"};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  if (::posix_spawnp(&pid_, "Xvfb", &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
  posix_spawn_file_actions_destroy(&actions);
  ::close(ends[1]);
  // Xvfb writes its number once it is ready.
  for (char digit = 0; ::read(ends[0], &digit, 1) == 1 && digit != '\n';) name_ += digit;
  ::close(ends[0]);
  if (name_.empty()) ADD_FAILURE() << "Xvfb does not start";
  name_ = ":" + name_;
}

VirtualDisplay::~VirtualDisplay() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGTERM);
  ::waitpid(pid_, nullptr, 0);
}

std::string find_free_port() { return TakenPort().port(); }

TakenPort::TakenPort() { socket_ = open_local_port(port_); }
TakenPort::~TakenPort() { ::close(socket_); }

TestFolder::TestFolder() {
  const ::testing::TestInfo* test = ::testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "." + test->name();
  std::ranges::replace(name, '/', '_');
  path_ = std::filesystem::path(::testing::TempDir()) / ("hapton_" + std::to_string(::getpid()) + "_" + name);
  std::filesystem::remove_all(path_);
  std::filesystem::create_directories(path_);
}

TestFolder::~TestFolder() {
  std::error_code ignored;
  if (!::testing::Test::HasFailure()) std::filesystem::remove_all(path_, ignored);
}

std::string read_text(const std::filesystem::path& path) {
  std::ifstream stream(path);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

}  // namespace hapton::process
