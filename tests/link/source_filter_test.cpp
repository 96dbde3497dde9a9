#include "link/source_filter.h"

#include <gtest/gtest.h>

#include <memory>

#include "link/udp_endpoint.h"
#include "runtime/clock.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

// True if a datagram that `from` sends arrives at `to`.
bool passes(Endpoint& from, Endpoint& to) {
  const std::array<std::byte, 20> datagram = {};
  std::array<std::byte, kMaxDatagramBytes> into = {};
  from.send(to.local_address(), datagram);
  const Received received = to.receive(into, SteadyClock().now_ns() + 20 * kMs);
  return received.bytes == datagram.size() && received.from == from.local_address();
}

void expect_only_the_peer_passes(const char* at) {
  const auto node = std::move(*open_udp_endpoint(at));
  const auto peer = std::move(*open_udp_endpoint(at));
  const auto other = std::move(*open_udp_endpoint(at));
  EXPECT_TRUE(passes(*other, *node)) << "there is no filter yet";
  ASSERT_TRUE(node->accept_only(peer->local_address()));
  for (int n = 0; n < 10; ++n) {
    EXPECT_TRUE(passes(*peer, *node));
    EXPECT_FALSE(passes(*other, *node));
  }
  // Now the other endpoint is the peer.
  ASSERT_TRUE(node->accept_only(other->local_address()));
  EXPECT_TRUE(passes(*other, *node));
  EXPECT_FALSE(passes(*peer, *node));
}

TEST(SourceFilter, LetsOnePeerThrough) { expect_only_the_peer_passes("127.0.0.1:0"); }

TEST(SourceFilter, LetsOnePeerThroughByIpv6) {
  if (!open_udp_endpoint("[::1]:0")) GTEST_SKIP() << "this machine has no IPv6";
  expect_only_the_peer_passes("[::1]:0");
}

TEST(SourceFilter, EveryBitOfTheAddressCounts) {
  const auto node = std::move(*open_udp_endpoint("127.0.0.1:0"));
  const auto peer = std::move(*open_udp_endpoint("127.0.0.1:0"));
  for (std::size_t bit = 0; bit < 32; ++bit) {
    Address almost = peer->local_address();
    almost.ip[12 + bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    ASSERT_TRUE(node->accept_only(almost));
    EXPECT_FALSE(passes(*peer, *node)) << bit;
  }
  for (std::size_t bit = 0; bit < 16; ++bit) {
    Address almost = peer->local_address();
    almost.port ^= static_cast<std::uint16_t>(1U << bit);
    ASSERT_TRUE(node->accept_only(almost));
    EXPECT_FALSE(passes(*peer, *node)) << bit;
  }
}

}  // namespace
}  // namespace hapton
