#include "runtime/service_notify.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>
#include <thread>

#include "tests/support/open_files.h"
#include "tests/support/patience.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

struct ServiceNotifyTest : testing::Test {
  void TearDown() override {
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  // Binds the socket to a name in the folder, and sets NOTIFY_SOCKET to that name.
  bool listen_as_manager(int socket, sockaddr_un& at) const {
    const std::string path = (folder.path() / "notify").string();
    at.sun_family = AF_UNIX;
    std::memcpy(at.sun_path, path.data(), path.size());
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
    return ::bind(socket, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0;
  }

  ScratchFolder folder;
};

TEST_F(ServiceNotifyTest, SaysNothingWithoutAListener) {
  ::unsetenv("NOTIFY_SOCKET");
  const ServiceNotify notify;
  EXPECT_FALSE(notify.has_manager());
  EXPECT_EQ(notify.manager_timeout_ns(), 0);
  EXPECT_FALSE(notify.send("READY=1"));
}

TEST_F(ServiceNotifyTest, TheManagerReceivesItAndSaysHowOftenItExpectsIt) {
  const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un at = {};
  ASSERT_TRUE(listen_as_manager(manager, at));
  ::setenv("WATCHDOG_USEC", "2000000", 1);
  const ServiceNotify notify;
  EXPECT_EQ(notify.manager_timeout_ns(), 2'000'000'000);
  ASSERT_TRUE(notify.send("READY=1"));
  std::array<char, 64> received = {};
  const ssize_t size = ::recv(manager, received.data(), received.size(), MSG_DONTWAIT);
  ::close(manager);
  ASSERT_GT(size, 0);
  EXPECT_EQ(std::string(received.data(), static_cast<std::size_t>(size)), "READY=1");
}

// In a container the socket of systemd is abstract: its name begins with @ in the variable, and with a zero byte in the address.
TEST_F(ServiceNotifyTest, AnAbstractSocketIsNotifiedAndTheSenderClosed) {
  const std::string name = "hapton_notify_" + std::to_string(::getpid());
  const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un at = {};
  at.sun_family = AF_UNIX;
  std::memcpy(at.sun_path + 1, name.data(), name.size());
  ASSERT_EQ(
      ::bind(manager, reinterpret_cast<const sockaddr*>(&at), static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size())),
      0);
  ::setenv("NOTIFY_SOCKET", ("@" + name).c_str(), 1);
  const ServiceNotify notify;
  const auto send_and_receive = [&] {
    EXPECT_TRUE(notify.send("WATCHDOG=1"));
    std::array<char, 64> received = {};
    EXPECT_EQ(::recv(manager, received.data(), received.size(), MSG_DONTWAIT), 10);
  };
  EXPECT_FALSE(leaves_files_open(send_and_receive)) << "it is sent for as long as the node runs";
  ::close(manager);
}

// sockaddr_un has 108 bytes, of which the last ends the name.
TEST_F(ServiceNotifyTest, ANameThatDoesNotFitMeansNoManager) {
  const std::string begin = folder.path().string() + "/";
  ASSERT_LT(begin.size(), 107U);
  const std::string longest = begin + std::string(107 - begin.size(), 'n');
  ::setenv("NOTIFY_SOCKET", longest.c_str(), 1);
  EXPECT_TRUE(ServiceNotify().has_manager());
  EXPECT_FALSE(ServiceNotify().send("READY=1")) << "nobody listens";
  ::setenv("NOTIFY_SOCKET", (longest + "n").c_str(), 1);
  EXPECT_FALSE(ServiceNotify().has_manager());
}

// The kernel keeps a few messages for a manager that hangs; the sender of one more would wait for the manager.
TEST_F(ServiceNotifyTest, AManagerThatReadsNoMessagesDelaysNoSender) {
  const int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un at = {};
  ASSERT_TRUE(listen_as_manager(manager, at));
  // Each message comes from a socket of its own: a single socket would reach its own limit first.
  const auto send_from_new_socket = [&] {
    const int other = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const bool is_sent = ::sendto(other, "x", 1, MSG_DONTWAIT, reinterpret_cast<const sockaddr*>(&at), sizeof at) == 1;
    ::close(other);
    return is_sent;
  };
  while (send_from_new_socket()) {
  }
  std::atomic<bool> has_returned = false;
  bool is_sent = true;
  std::thread sender([&] {
    is_sent = ServiceNotify().send("WATCHDOG=1");
    has_returned = true;
  });
  EXPECT_TRUE(wait_until([&] { return has_returned.load(); }));
  std::array<char, 64> received = {};
  const auto take = [&] { return ::recv(manager, received.data(), received.size(), MSG_DONTWAIT); };
  while (take() > 0) {
  }
  sender.join();
  EXPECT_FALSE(is_sent);
  EXPECT_TRUE(ServiceNotify().send("WATCHDOG=1")) << "the next one goes out again";
  EXPECT_EQ(take(), 10) << "bytes of WATCHDOG=1";
  ::close(manager);
}

TEST_F(ServiceNotifyTest, InvalidTextInTheEnvironmentIsNoPeriod) {
  ::setenv("WATCHDOG_USEC", "soon", 1);
  EXPECT_EQ(ServiceNotify().manager_timeout_ns(), 0);
}

}  // namespace
}  // namespace hapton
