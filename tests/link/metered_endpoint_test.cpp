#include "link/metered_endpoint.h"

#include <gtest/gtest.h>

#include <array>

#include "link/memory_endpoint.h"

namespace hapton {
namespace {

TEST(MeteredEndpointTest, CountsAndTimesWhatPasses) {
  SimulatedClock clock(1000);
  MemoryNetwork network(clock, {.delay_ns = 500});
  const auto inner = *network.open(memory_address(1, 1));
  const auto other = *network.open(memory_address(2, 1));
  MeteredEndpoint metered(*inner, clock);
  EXPECT_EQ(metered.local_address(), inner->local_address());

  const std::array<std::byte, 30> bytes = {};
  ASSERT_TRUE(metered.send(other->local_address(), bytes));
  EXPECT_EQ(metered.last_send_ns(), 1000);
  std::array<std::byte, kMaxDatagramBytes + 1> buffer = {};
  EXPECT_FALSE(metered.send(other->local_address(), buffer));
  EXPECT_EQ(metered.counts().datagrams_sent, 1U);
  EXPECT_EQ(metered.counts().bytes_sent, 30U);

  other->send(inner->local_address(), std::span(bytes).first(7));
  EXPECT_EQ(metered.receive(buffer, 10'000).bytes, 7U);
  EXPECT_EQ(metered.last_receive_ns(), 1500);
  EXPECT_EQ(metered.receive(buffer, 10'000).bytes, 0U);
  EXPECT_EQ(metered.last_receive_ns(), 1500);
  EXPECT_EQ(metered.counts().datagrams_received, 1U);
  EXPECT_EQ(metered.counts().bytes_received, 7U);
}

}  // namespace
}  // namespace hapton
