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

constexpr std::int64_t kLivenessSecondNs = 1'000'000'000;

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
  std::string take_notifications() {
    std::string all;
    std::array<char, 64> notification = {};
    for (ssize_t size = 0; (size = ::recv(manager, notification.data(), notification.size(), MSG_DONTWAIT)) > 0;) {
      all += std::string(notification.data(), static_cast<std::size_t>(size)) + " ";
    }
    return all;
  }
  ScratchFolder folder;
  int manager = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
};

TEST_F(ServiceLivenessTest, TheProgramIsReadyAndLivesWithItsOnlySession) {
  ServiceLiveness service(1);
  service.note(0, true, kLivenessSecondNs);
  EXPECT_EQ(take_notifications(), "READY=1 WATCHDOG=1 ");
  service.note(0, true, 2 * kLivenessSecondNs);
  EXPECT_EQ(take_notifications(), "WATCHDOG=1 ") << "ready once";
  service.note(0, false, 3 * kLivenessSecondNs);
  EXPECT_EQ(take_notifications(), "");
}

TEST_F(ServiceLivenessTest, IsReadyOnceAllSessionsAre) {
  ServiceLiveness service(2);
  service.note(1, true, kLivenessSecondNs);
  EXPECT_EQ(take_notifications(), "");
  service.note(0, true, kLivenessSecondNs);
  EXPECT_EQ(take_notifications(), "READY=1 WATCHDOG=1 ");
}

TEST_F(ServiceLivenessTest, LivesNoLongerThanEachSession) {
  ServiceLiveness service(2);
  service.note(0, true, kLivenessSecondNs);
  service.note(1, true, kLivenessSecondNs);
  (void)take_notifications();
  service.note(0, false, kLivenessSecondNs + 1);
  service.note(1, true, kLivenessSecondNs + 2);
  EXPECT_EQ(take_notifications(), "") << "the device loop of the first hangs";
  service.note(0, true, kLivenessSecondNs + 3);
  EXPECT_EQ(take_notifications(), "WATCHDOG=1 ");
  service.note(1, true, kLivenessSecondNs + 3 + 2 * kLivenessSecondNs);
  EXPECT_EQ(take_notifications(), "") << "the first session itself hangs";
}

TEST_F(ServiceLivenessTest, ASessionThatHasEndedCountsNoMore) {
  ServiceLiveness service(2);
  service.leave(0);
  service.note(1, true, kLivenessSecondNs);
  EXPECT_EQ(take_notifications(), "READY=1 WATCHDOG=1 ");
}

}  // namespace
}  // namespace hapton
