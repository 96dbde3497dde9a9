#include "tests/dds/bridge.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace hapton::dds_test {
namespace {

using process::kPatience;
using process::Program;
using process::System;

int choose_own_domain() {
  for (int i = 0;; ++i) {
    const int domain = 1 + (static_cast<int>(::getpid()) + i) % 90;
    const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un name = {};
    name.sun_family = AF_UNIX;
    // A name that begins with a zero byte is not a file; it vanishes with its socket.
    const std::string text = "hapton dds_test in domain " + std::to_string(domain);
    text.copy(name.sun_path + 1, sizeof(name.sun_path) - 1);
    if (::bind(socket, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0) return domain;
    ::close(socket);
    if (i == 90) return domain;
  }
}

}  // namespace

int domain() {
  static const int chosen_domain = choose_own_domain();
  return chosen_domain;
}

Bridge::Bridge(const std::string& hub, const std::filesystem::path& folder, const std::vector<std::string>& more,
               const std::string& interface) {
  std::vector<std::string> arguments = {"dds", "--hub", hub, "--domain", std::to_string(domain())};
  if (!interface.empty()) arguments.insert(arguments.end(), {"--interface", interface});
  arguments.insert(arguments.end(), more.begin(), more.end());
  program_ = std::make_unique<Program>("hapton", arguments, folder);
}

bool Bridge::is_publishing() {
  return System::wait_until([&] { return program_->out().starts_with("publishing ") || !program_->is_running(); }) &&
         program_->is_running();
}

std::string Bridge::end() {
  program_->send_signal(SIGINT);
  const auto ended = program_->wait(kPatience);
  if (!ended) return "does not end";
  EXPECT_EQ(ended->exit_code, 0) << ended->err;
  return ended->out;
}

}  // namespace hapton::dds_test
