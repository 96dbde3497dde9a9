#include "link/relay_endpoint.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/patience.h"
#include "tests/support/text_bytes.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

constexpr std::int64_t kRelayTimeoutNs = 30'000 * kMs;

// A hub, some nodes and the relay between them, all in this thread.
struct Relays : testing::Test {
  void open(const LinkFaults& to_hub, const LinkFaults& to_nodes = {}) {
    FaultPhase phase{.name = "test", .to_hub = to_hub, .to_nodes = to_nodes};
    relay.emplace(*RelayEndpoint::open({.listen = "127.0.0.1:0", .hub = hub->local_address(), .schedule = {{phase}, false}, .seed = 3}));
  }

  // The text of the next datagram at this endpoint; empty if none comes in time.
  std::string receive(Endpoint& at, std::int64_t timeout_ns = kRelayTimeoutNs) {
    const std::int64_t end_ns = clock.now_ns() + timeout_ns;
    do {
      relay->run_for_ns(kMs);
      last = at.receive(buffer, 0);
      if (last.bytes > 0) return {reinterpret_cast<const char*>(buffer.data()), last.bytes};
    } while (clock.now_ns() < end_ns);
    return {};
  }

  // Sends this many numbered datagrams to the hub and lets the relay handle all of them.
  void send_numbered(Endpoint& from, int count, int first = 0) {
    for (int n = first; n < first + count; ++n) {
      const auto before = relay->to_hub().received;
      ASSERT_TRUE(from.send(relay->local_address(), bytes_of(std::to_string(n))));
      const std::int64_t end_ns = clock.now_ns() + kRelayTimeoutNs;
      while (relay->to_hub().received == before && clock.now_ns() < end_ns) relay->run_for_ns(kMs / 10);
    }
  }

  // All texts that arrive: the first `at_least` of them, however long they take, then those that come within 100 ms of the one before.
  std::vector<std::string> receive_rest(Endpoint& at, std::size_t at_least) {
    std::vector<std::string> texts;
    for (;;) {
      const std::string text = receive(at, texts.size() < at_least ? kRelayTimeoutNs : 100 * kMs);
      if (text.empty()) return texts;
      texts.push_back(text);
    }
  }

  SteadyClock clock;
  std::unique_ptr<Endpoint> hub = *open_udp_endpoint("127.0.0.1:0");
  std::unique_ptr<Endpoint> node = *open_udp_endpoint("127.0.0.1:0");
  std::unique_ptr<Endpoint> other = *open_udp_endpoint("127.0.0.1:0");
  std::optional<RelayEndpoint> relay;
  std::array<std::byte, kMaxDatagramBytes> buffer = {};
  Received last;
};

TEST_F(Relays, CarryBothWaysAndGiveEachNodeAPortOfItsOwn) {
  open({});
  ASSERT_TRUE(node->send(relay->local_address(), bytes_of("from node")));
  EXPECT_EQ(receive(*hub), "from node");
  const Address node_address = last.from;
  ASSERT_TRUE(other->send(relay->local_address(), bytes_of("from other")));
  EXPECT_EQ(receive(*hub), "from other");
  EXPECT_NE(last.from, node_address);
  ASSERT_TRUE(hub->send(node_address, bytes_of("to node")));
  EXPECT_EQ(receive(*node), "to node");
  EXPECT_EQ(last.from, relay->local_address());
  EXPECT_EQ(relay->clients(), 2U);
  EXPECT_EQ(relay->to_hub().forwarded, 2U);
  EXPECT_EQ(relay->to_nodes().forwarded, 1U);
}

TEST_F(Relays, LoseWhatTheyCountAsLostAndNothingElse) {
  open({.loss = 0.5});
  send_numbered(*node, 200);
  const auto arrived = receive_rest(*hub, relay->to_hub().forwarded);
  EXPECT_EQ(arrived.size(), relay->to_hub().forwarded);
  EXPECT_EQ(relay->to_hub().forwarded + relay->to_hub().lost, 200U);
  EXPECT_GT(relay->to_hub().lost, 60U);
  EXPECT_GT(relay->to_hub().forwarded, 60U);
}

TEST_F(Relays, CountWhatABurstLosesApart) {
  open({.burst_share = 0.5, .burst_length = 4.0});
  send_numbered(*node, 200);
  const auto arrived = receive_rest(*hub, relay->to_hub().forwarded);
  EXPECT_EQ(arrived.size() + relay->to_hub().lost_in_burst, 200U);
  EXPECT_EQ(relay->to_hub().lost, 0U);
  EXPECT_GT(relay->to_hub().lost_in_burst, 30U);
  EXPECT_EQ(relay->phase(), 0U);
}

TEST_F(Relays, CopyAndCorrupt) {
  open({.duplicate = 1.0});
  send_numbered(*node, 20);
  EXPECT_EQ(receive_rest(*hub, 40).size(), 40U);
  open({.corrupt = 1.0});
  ASSERT_TRUE(node->send(relay->local_address(), bytes_of("whole")));
  const std::string corrupted = receive(*hub);
  EXPECT_EQ(corrupted.size(), 5U);
  EXPECT_NE(corrupted, "whole");
}

TEST_F(Relays, DeliverLateWhatIsDelayedAndOutOfOrderWhatIsHeldBack) {
  open({.delay_ns = 30 * kMs});
  ASSERT_TRUE(node->send(relay->local_address(), bytes_of("late")));
  const std::int64_t sent_ns = clock.now_ns();
  EXPECT_EQ(receive(*hub), "late");
  EXPECT_GE(clock.now_ns() - sent_ns, 29 * kMs);

  open({.reorder = 0.3, .reorder_by_ns = 20 * kMs});
  send_numbered(*node, 50);
  const auto arrived = receive_rest(*hub, 50);
  EXPECT_EQ(std::set<std::string>(arrived.begin(), arrived.end()).size(), 50U);
  EXPECT_GT(relay->to_hub().held_back, 0U);
}

// Each datagram is due when its delay is over, however many come after it.
TEST_F(Relays, DeliverDelayedDatagramsInOrderWhileMoreCome) {
  open({.delay_ns = 20 * kMs});
  std::vector<std::string> arrived;
  const std::int64_t end_ns = clock.now_ns() + kRelayTimeoutNs;
  for (int n = 0; arrived.size() < 10 && clock.now_ns() < end_ns; ++n) {
    send_numbered(*node, 1, n);
    relay->run_for_ns(kMs);
    last = hub->receive(buffer, 0);
    if (last.bytes > 0) arrived.emplace_back(reinterpret_cast<const char*>(buffer.data()), last.bytes);
  }
  EXPECT_THAT(arrived, testing::ElementsAre("0", "1", "2", "3", "4", "5", "6", "7", "8", "9"));
}

TEST_F(Relays, KeepTheTwoWaysApart) {
  open({.partition = true}, {});
  ASSERT_TRUE(node->send(relay->local_address(), bytes_of("x")));
  EXPECT_TRUE(wait_until([&] {
    EXPECT_EQ(receive(*hub, kMs), "");
    return relay->to_hub().partitioned == 1U;
  }));
  EXPECT_EQ(receive(*hub, 50 * kMs), "");
  EXPECT_EQ(relay->to_hub().partitioned, 1U);

  open({}, {.partition = true});
  ASSERT_TRUE(node->send(relay->local_address(), bytes_of("to hub")));
  ASSERT_EQ(receive(*hub), "to hub");
  ASSERT_TRUE(hub->send(last.from, bytes_of("to node")));
  EXPECT_TRUE(wait_until([&] {
    EXPECT_EQ(receive(*node, kMs), "");
    return relay->to_nodes().partitioned == 1U;
  }));
  EXPECT_EQ(receive(*node, 50 * kMs), "");
  EXPECT_EQ(relay->to_hub().partitioned, 0U);
}

TEST_F(Relays, GoOnWhileTheHubIsAway) {
  open({});
  const std::string at = to_string(hub->local_address());
  hub.reset();
  send_numbered(*node, 10);
  hub = *open_udp_endpoint(at);
  // An ICMP error of a port without a receiver may affect the next call or two.
  std::string text;
  for (int n = 0; n < 100 && text.empty(); ++n) {
    send_numbered(*node, 1);
    text = receive(*hub, 20 * kMs);
  }
  EXPECT_EQ(text, "0");
}

TEST_F(Relays, HoldNoMoreThanTheyMay) {
  open({.delay_ns = 60'000 * kMs});
  std::uint64_t sent = 0;
  while (relay->to_hub().overflowed == 0 && sent < 10 * RelayEndpoint::kMaxQueued) {
    for (int n = 0; n < 100; ++n) sent += node->send(relay->local_address(), bytes_of("flood")) ? 1 : 0;
    relay->run_for_ns(kMs);
  }
  EXPECT_GT(relay->to_hub().overflowed, 0U);
  std::vector<std::unique_ptr<Endpoint>> nodes;
  for (std::size_t n = 0; n < RelayEndpoint::kMaxClients + 5; ++n) {
    nodes.push_back(*open_udp_endpoint("127.0.0.1:0"));
    send_numbered(*nodes.back(), 1);
  }
  EXPECT_EQ(relay->clients(), RelayEndpoint::kMaxClients);
  EXPECT_GE(relay->to_hub().rejected, 5U);
}

TEST_F(Relays, SayWhatIsWrongInOneLine) {
  const auto complaint = [](RelaySettings settings) {
    const auto opened = RelayEndpoint::open(std::move(settings));
    return opened ? std::string() : opened.error().what;
  };
  EXPECT_THAT(complaint({.listen = "nowhere:x", .hub = {}, .schedule = {}}), testing::HasSubstr("nowhere"));
  EXPECT_THAT(complaint({.listen = to_string(hub->local_address()), .hub = {}, .schedule = {}}),
              testing::HasSubstr("another program holds this port"));
  FaultPhase bad{.name = "storm", .to_hub = {.loss = 2.0}, .to_nodes = {}};
  EXPECT_THAT(complaint({.listen = "127.0.0.1:0", .hub = {}, .schedule = {{bad}, false}}), testing::HasSubstr("'storm': loss is 2"));
}

}  // namespace
}  // namespace hapton
