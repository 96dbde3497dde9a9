// Nodes that are far away: handshakes over long round trips.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "link/sealed_client.h"
#include "link/sealed_hub.h"
#include "tests/link/sealed_hub_fixture.h"

namespace hapton::sealed_hub {
namespace {

// 980 ms and more: as over two geostationary satellites in a row.
TEST_F(SealedHubTest, ANodeAtARoundTripOfASecondJoinsAndStays) {
  for (const double loss : {0.0, 0.1, 0.3}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(testing::Message() << "loss " << loss << ", seed " << seed);
      start_hub();
      network_.set_impairments({.seed = seed, .loss = loss, .delay_ns = 490 * kMs, .jitter_ns = 20 * kMs});
      const auto node = make_node(static_cast<std::uint8_t>(seed + 1));
      replies_ = 0;
      run_for({node.get()}, loss == 0.0 ? 3'300 : 12'000);
      EXPECT_GT(replies_, 0) << "it has not joined";
      const std::uint64_t handshakes = node->sealed.seal_counts().handshakes;
      replies_ = 0;
      run_for({node.get()}, 10'000);
      // The node sends ten datagrams a second; for a reply, both ways must succeed.
      EXPECT_GT(replies_, static_cast<int>(0.5 * 100 * (1.0 - loss) * (1.0 - loss)));
      if (loss == 0.0) {
        EXPECT_EQ(node->sealed.seal_counts().handshakes, handshakes) << "it agreed on sessions that it did not need";
      }
      EXPECT_EQ(hub_->seal_counts().forged, 0U);
    }
  }
}

// All nodes join at the same time, as after a restart of the hub: they send more requests than there are slots for candidates.
TEST_F(SealedHubTest, SeveralNodesAtARoundTripOfASecondDoNotDisplaceEachOther) {
  network_.set_impairments({.seed = 1, .delay_ns = 500 * kMs});
  for (const auto& [role, count] : {std::pair(KeyRole::haptics, 2), std::pair(KeyRole::vision, 8)}) {
    SCOPED_TRACE(count);
    start_hub();
    std::vector<std::unique_ptr<Node>> nodes;
    std::vector<Node*> all;
    for (int i = 0; i < count; ++i) {
      nodes.push_back(make_node(static_cast<std::uint8_t>(10 + i), key_of(1), role));
      all.push_back(nodes.back().get());
    }
    run_for(all, 4'000);
    EXPECT_EQ(hub_->seal_counts().handshakes, static_cast<std::uint64_t>(count));
    EXPECT_EQ(hub_->seal_counts().too_many_handshakes, 0U);
    for (const auto& node : nodes) EXPECT_TRUE(hub_sends(*node, "here"));
  }
}

// The hub was busy for this time when the node joined. The node adds the time, but at most two seconds, to its timeout for the hub.
TEST_F(SealedHubTest, ALongRoundTripAddsTwoSecondsToTheTimeoutAtMost) {
  for (const std::int64_t trip_ms : {500, 1'500, 2'500}) {
    SCOPED_TRACE(trip_ms);
    start_hub();
    const auto node = make_node(2);
    node_sends(*node, "first");
    hub_receives();        // sends a cookie
    node_receives(*node);  // requests with the cookie
    clock_.advance_ns(trip_ms * kMs);
    hub_receives();  // agrees on a session
    node_receives(*node);
    ASSERT_EQ(node->sealed.seal_counts().handshakes, 1U);
    hub_receives();
    const std::size_t arrived = hub_endpoint_.arrived().size();
    const std::int64_t timeout_ns = SealedClient::kPeerTimeoutNs + std::min(trip_ms * kMs, SealedClient::kMaxTripNs);
    clock_.advance_ns(timeout_ns - kMs);
    node_receives(*node);
    hub_receives();
    EXPECT_EQ(hub_endpoint_.arrived().size(), arrived) << "it waits";
    clock_.advance_ns(kMs);
    node_receives(*node);
    hub_receives();
    EXPECT_EQ(hub_endpoint_.arrived().size(), arrived + 1) << "it requests a session";
  }
}

TEST_F(SealedHubTest, AnAddressGetsAnotherReplyOnlyWhenItsReplyMayBeLost) {
  const auto node = make_node(2);
  node_sends(*node, "first");
  hub_receives();        // sends a cookie
  node_receives(*node);  // requests with the cookie, and again every 50 ms
  std::vector<std::int64_t> replied_ms;
  for (std::int64_t ms = 0; ms < 3000; ms += 10) {
    const std::size_t before = hub_endpoint_.sent();
    hub_receives();
    if (hub_endpoint_.sent() > before) replied_ms.push_back(ms);
    std::array<std::byte, kMaxDatagramBytes> lost;
    while (node->endpoint.receive(lost, 0).bytes != 0) {
    }
    clock_.advance_ns(10 * kMs);
    node_sends(*node, "again");
  }
  ASSERT_GE(replied_ms.size(), 6U);
  std::int64_t min_gap_ms = SealedHub::kReplyEveryNs / kMs;
  for (std::size_t i = 1; i < replied_ms.size(); ++i) {
    const std::int64_t gap_ms = replied_ms[i] - replied_ms[i - 1];
    // Replies of more than kReplyLivesNs ago no longer count.
    if (i <= 4) {
      EXPECT_GE(gap_ms, min_gap_ms);
    }
    EXPECT_GE(gap_ms, std::min<std::int64_t>(min_gap_ms, 400));
    EXPECT_LE(gap_ms, min_gap_ms + 60);
    min_gap_ms = std::min(2 * min_gap_ms, SealedHub::kMaxReplyEveryNs / kMs);
  }
  EXPECT_GT(hub_->seal_counts().repeats, 30U);
}

}  // namespace
}  // namespace hapton::sealed_hub
