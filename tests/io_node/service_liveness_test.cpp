#include "io_node/service_liveness.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string>

#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

constexpr std::int64_t kTimeNs = 1'000'000'000;  // a second

struct ServiceLivenessTest : testing::Test {
  ServiceLivenessTest() {
    const std::string path = (folder.path() / "notify").string();
    sockaddr_un at = {};
    at.sun_family = AF_UNIX;
    std::memcpy(at.sun_path, path.data(), path.size());
    EXPECT_EQ(::bind(manager, reinterpret_cast<const sockaddr*>(&at), sizeof at), 0);
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
    ::setenv("WATCHDOG_USEC", "2000000", 1);
  }
  ~ServiceLivenessTest() override {
    ::close(manager);
    ::unsetenv("NOTIFY_SOCKET");
    ::unsetenv("WATCHDOG_USEC");
  }
  // All notifications that have arrived since the last call, each followed by a space.
  std::string received() {
    std::string all;
    std::array<char, 64> one = {};
    for (ssize_t size = 0; (size = ::recv(manager, one.data(), one.size(), MSG_DONTWAIT)) > 0;) {
      all += std::string(one.data(), static_cast<std::size_t>(size)) + " ";
    }
    return all;
  }
  ScratchFolder folder;
  int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

TEST_F(ServiceLivenessTest, TheProgramIsReadyAndLivesWithItsOnlySession) {
  ServiceLiveness service(1);
  service.note(0, true, kTimeNs);
  EXPECT_EQ(received(), "READY=1 WATCHDOG=1 ");
  service.note(0, true, 2 * kTimeNs);
  EXPECT_EQ(received(), "WATCHDOG=1 ") << "ready once";
  service.note(0, false, 3 * kTimeNs);
  EXPECT_EQ(received(), "");
}

TEST_F(ServiceLivenessTest, IsReadyOnceAllSessionsAre) {
  ServiceLiveness service(2);
  service.note(1, true, kTimeNs);
  EXPECT_EQ(received(), "");
  service.note(0, true, kTimeNs);
  EXPECT_EQ(received(), "READY=1 WATCHDOG=1 ");
}

TEST_F(ServiceLivenessTest, LivesNoLongerThanEachOfThem) {
  ServiceLiveness service(2);
  service.note(0, true, kTimeNs);
  service.note(1, true, kTimeNs);
  (void)received();
  service.note(0, false, kTimeNs + 1);
  service.note(1, true, kTimeNs + 2);
  EXPECT_EQ(received(), "") << "the device loop of the first hangs";
  service.note(0, true, kTimeNs + 3);
  EXPECT_EQ(received(), "WATCHDOG=1 ");
  service.note(1, true, kTimeNs + 3 + 2 * kTimeNs);
  EXPECT_EQ(received(), "") << "the first session hangs itself";
}

TEST_F(ServiceLivenessTest, OneThatHasEndedCountsNoMore) {
  ServiceLiveness service(2);
  service.leave(0);
  service.note(1, true, kTimeNs);
  EXPECT_EQ(received(), "READY=1 WATCHDOG=1 ");
}

}  // namespace
}  // namespace hapton
