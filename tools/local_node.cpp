#include "tools/local_node.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <utility>

#include "link/udp_endpoint.h"

namespace hapton {
namespace {

constexpr double kReadyTimeoutS = 120.0;  // the longest time until a node is ready; the haptics node loads and prepares its scene

// The node ends with this program even if this program is killed: then the kernel sends the node SIGTERM, as a stop would.
// Source: setpriv(1), --pdeathsig; util-linux is on every Debian machine.
ChildCommand make_command(const std::filesystem::path& program, std::vector<std::string> arguments, const std::filesystem::path& log) {
  constexpr const char* kSetpriv = "/usr/bin/setpriv";
  if (::access(kSetpriv, X_OK) != 0 || ::access(program.c_str(), X_OK) != 0) {
    return {.program = program, .arguments = std::move(arguments), .folder = {}, .output = log};
  }
  std::vector<std::string> words = {"--pdeathsig", "TERM", "--", program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return {.program = kSetpriv, .arguments = std::move(words), .folder = {}, .output = log};
}

}  // namespace

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

Result<std::string> find_free_address() {
  const auto endpoint = open_udp_endpoint("127.0.0.1:0");
  if (!endpoint) {
    return tl::unexpected(endpoint.error());
  }
  return to_string((*endpoint)->local_address());
}

LocalNode::LocalNode(std::string name, std::filesystem::path log, ChildProcess process)
    : name_(std::move(name)), log_(std::move(log)), process_(std::move(process)) {}

Result<LocalNode> LocalNode::start(const std::filesystem::path& folder, const std::string& name, const std::filesystem::path& program,
                                   std::vector<std::string> arguments) {
  const auto log = folder / (name + ".log");
  auto process = ChildProcess::start(make_command(program, std::move(arguments), log));
  if (!process) {
    return tl::unexpected(process.error());
  }
  return LocalNode(name, log, std::move(*process));
}

template <class Condition>
Result<void> LocalNode::wait_until(Condition&& is_met_by_log) {
  constexpr double kPollSeconds = 0.05;  // between two readings of the log; a free choice
  for (double waited = 0.0; waited < kReadyTimeoutS; waited += kPollSeconds) {
    const auto code = process_.wait(kPollSeconds);
    if (is_met_by_log(read_text(log_))) {
      return {};
    }
    if (code) {
      return exit_error(*code);
    }
  }
  return fail("{} was not ready after {} s; see {}", name_, kReadyTimeoutS, log_.string());
}

Result<void> LocalNode::wait_for(const std::string& text) {
  return wait_until([&](const std::string& log) { return log.find(text) != std::string::npos; });
}

Result<std::string> LocalNode::wait_for_number() {
  std::string number;
  const auto found = wait_until([&](const std::string& log) {
    std::istringstream lines(log);
    // A last line without a line end is not read, because it may still be incomplete.
    while (std::getline(lines, number) && !lines.eof()) {
      if (!number.empty() && number.find_first_not_of("0123456789") == std::string::npos) return true;
    }
    return false;
  });
  return found ? Result<std::string>(number) : tl::unexpected(found.error());
}

Result<void> LocalNode::wait_for_end(double seconds) {
  const auto code = process_.wait(seconds);
  if (!code) {
    return fail("{} did not end; see {}", name_, log_.string());
  }
  return *code == 0 ? Result<void>() : exit_error(*code);
}

Result<void> LocalNode::check_running() {
  const auto code = process_.wait(0.0);
  return code ? exit_error(*code) : Result<void>();
}

Result<void> LocalNode::stop() {
  // A vision node with a mesh of a million triangles first finishes its level of detail, which takes seconds on a busy machine.
  constexpr double kStopTimeoutS = 30.0;
  const int code = process_.stop(kStopTimeoutS);
  return code == 0 ? Result<void>() : exit_error(code);
}

std::string LocalNode::last_line() const {
  std::string text = read_text(log_);
  text.erase(text.find_last_not_of(" \n") + 1);
  return text.substr(text.rfind('\n') + 1);
}

Result<void> LocalNode::exit_error(int code) const { return fail("{} ended with {}: {}", name_, code, last_line()); }

LocalDisplay::~LocalDisplay() {
  if (server_) ::unsetenv("DISPLAY");
}

Result<LocalRelay> start_local_relay(const std::filesystem::path& folder, const std::string& hub, const std::vector<std::string>& faults) {
  std::vector<std::string> words = {"relay", "--hub", hub};
  words.insert(words.end(), faults.begin(), faults.end());
  auto node = LocalNode::start(folder, "relay", find_own_folder() / "hapton", std::move(words));
  if (!node) return tl::unexpected(node.error());
  if (const auto ready = node->wait_for(", hub "); !ready) return tl::unexpected(ready.error());
  // The line is "relay at ADDRESS, hub ...".
  const std::string line = node->last_line();
  const std::string prefix = "relay at ";
  return LocalRelay{std::move(*node), line.substr(prefix.size(), line.find(',') - prefix.size())};
}

Result<void> LocalDisplay::start_if_none(const std::filesystem::path& folder) {
  if (const char* display = std::getenv("DISPLAY"); display != nullptr && *display != '\0') return {};
  auto started =
      LocalNode::start(folder, "Xvfb", "Xvfb", {"-displayfd", "1", "-screen", "0", "1280x720x24", "-nolisten", "tcp", "-noreset"});
  if (!started) {
    return tl::unexpected(started.error());
  }
  // Xvfb prints the number of the display among other lines.
  const auto number = started->wait_for_number();
  if (!number) {
    return tl::unexpected(number.error());
  }
  ::setenv("DISPLAY", (":" + *number).c_str(), 1);
  server_.emplace(std::move(*started));
  return {};
}

Result<void> LocalVision::start(const std::filesystem::path& folder, std::vector<std::string> arguments) {
  if (const auto shown = display_.start_if_none(folder); !shown) {
    return shown;
  }
  arguments.push_back("--offscreen");
  auto started = LocalNode::start(folder, "vision_node", find_own_folder() / "vision_node", std::move(arguments));
  if (!started) {
    return tl::unexpected(started.error());
  }
  node_.emplace(std::move(*started));
  return {};
}

Result<void> LocalVision::stop() { return node_ ? node_->stop() : Result<void>(); }

}  // namespace hapton
