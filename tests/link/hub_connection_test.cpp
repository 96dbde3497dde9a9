#include "link/hub_connection.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <string>
#include <thread>

#include "link/hub_peers.h"
#include "link/link_key.h"
#include "link/sealed_hub.h"
#include "link/udp_endpoint.h"
#include "runtime/start_thread.h"
#include "tests/support/scratch_folder.h"

namespace hapton {
namespace {

class HubConnectionTest : public ::testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(make_key_file(key_)); }

  // Runs `use` with the address of a hub, which replies meanwhile.
  template <class Use>
  void with_hub(Use&& use) {
    auto endpoint = open_udp_endpoint("127.0.0.1:0");
    ASSERT_TRUE(endpoint);
    const std::string address = to_string((*endpoint)->local_address());
    std::atomic<bool> is_done{false};
    std::thread hub = start_thread([&] {
      SteadyClock clock;
      SealedHub sealed(**endpoint, clock, *read_key_file(key_));
      HubPeers peers(sealed, clock, 1, 1000.0);
      while (!is_done) {
        Datagram datagram;
        peers.receive(datagram, clock.now_ns() + kNanosecondsPerMillisecond);
      }
    });
    use(address);
    is_done = true;
    hub.join();
  }

  ScratchFolder folder_;
  std::filesystem::path key_ = folder_.path() / "hapton.key";
};

TEST_F(HubConnectionTest, EachRoleJoins) {
  for (const NodeRole role : {NodeRole::haptics, NodeRole::vision, NodeRole::tool}) {
    with_hub([&](const std::string& hub) {
      const auto connection = HubConnection::open(role, {.hub = hub, .key_file = key_.string(), .has_worker = true});
      ASSERT_TRUE(connection) << connection.error().what;
      const auto joined = (*connection)->wait_until_joined(30.0);
      EXPECT_TRUE(joined) << joined.error().what;
      EXPECT_EQ((*connection)->client().servo_rate_hz(), 1000.0);
    });
  }
}

// If the machine stands still for 50 ms, the second node rightly takes over; then the test tries again.
TEST_F(HubConnectionTest, ASecondHapticsNodeGetsTheReason) {
  std::string reason;
  for (int attempt = 0; attempt < 10 && reason.empty(); ++attempt) {
    with_hub([&](const std::string& hub) {
      const auto first = HubConnection::open(NodeRole::haptics, {.hub = hub, .key_file = key_.string()});
      ASSERT_TRUE(first && (*first)->wait_until_joined(30.0));
      std::atomic<bool> is_done{false};
      std::thread first_thread = start_thread([&] {
        Datagram datagram;
        while (!is_done) (*first)->client().receive(datagram, (*first)->clock().now_ns() + 5 * kNanosecondsPerMillisecond);
      });
      const auto second = HubConnection::open(NodeRole::haptics, {.hub = hub, .key_file = key_.string()});
      if (second) {
        if (const auto joined = (*second)->wait_until_joined(30.0); !joined) reason = joined.error().what;
      }
      is_done = true;
      first_thread.join();
    });
  }
  EXPECT_NE(reason.find("has a haptics node already"), std::string::npos) << reason;
}

TEST_F(HubConnectionTest, SaysWhatIsMissing) {
  const auto bad_address = HubConnection::open(NodeRole::tool, {.hub = "4950", .key_file = key_.string()});
  ASSERT_FALSE(bad_address);
  EXPECT_NE(bad_address.error().what.find("4950"), std::string::npos);
  const auto no_key = HubConnection::open(NodeRole::tool, {.hub = "127.0.0.1", .key_file = (folder_.path() / "none").string()});
  ASSERT_FALSE(no_key);
  EXPECT_NE(no_key.error().what.find("none"), std::string::npos);
  const auto nobody = HubConnection::open(NodeRole::tool, {.hub = "127.0.0.1:9", .key_file = key_.string()});
  ASSERT_TRUE(nobody);
  const auto joined = (*nobody)->wait_until_joined(0.05);
  ASSERT_FALSE(joined);
  EXPECT_NE(joined.error().what.find("no reply from a hub at 127.0.0.1:9"), std::string::npos);
}

}  // namespace
}  // namespace hapton
