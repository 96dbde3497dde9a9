#include "link/memory_endpoint.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

class MemoryEndpointTest : public testing::Test {
 protected:
  void open(const Impairments& impairments = {}) {
    network_ = std::make_unique<MemoryNetwork>(clock_, impairments);
    a_ = *network_->open(memory_address(1, 100));
    b_ = *network_->open(memory_address(2, 100));
  }

  void send(std::uint8_t number) {
    const std::array<std::byte, 1> bytes = {std::byte{number}};
    ASSERT_TRUE(a_->send(b_->local_address(), bytes));
  }

  // The numbers that arrive until the deadline.
  std::vector<int> receive_all(std::int64_t wait_ns) {
    std::vector<int> numbers;
    const std::int64_t deadline_ns = clock_.now_ns() + wait_ns;
    std::array<std::byte, kMaxDatagramBytes> buffer;
    while (b_->receive(buffer, deadline_ns).bytes > 0) {
      numbers.push_back(std::to_integer<int>(buffer[0]));
    }
    return numbers;
  }

  SimulatedClock clock_;
  std::unique_ptr<MemoryNetwork> network_;
  std::unique_ptr<Endpoint> a_;
  std::unique_ptr<Endpoint> b_;
};

TEST_F(MemoryEndpointTest, DeliversInOrderAndMovesTheClockToTheDeadline) {
  open();
  send(1);
  send(2);
  const std::int64_t start_ns = clock_.now_ns();
  EXPECT_EQ(receive_all(5 * kMs), (std::vector<int>{1, 2}));
  EXPECT_EQ(clock_.now_ns(), start_ns + 5 * kMs);
}

TEST_F(MemoryEndpointTest, DelaysAndMovesTheClockToTheArrival) {
  open({.delay_ns = 3 * kMs});
  send(1);
  std::array<std::byte, 8> buffer = {};
  const std::int64_t start_ns = clock_.now_ns();
  EXPECT_EQ(b_->receive(buffer, start_ns + 2 * kMs).bytes, 0U);
  const Received received = b_->receive(buffer, start_ns + 10 * kMs);
  EXPECT_EQ(received.bytes, 1U);
  EXPECT_EQ(received.from, a_->local_address());
  EXPECT_EQ(clock_.now_ns(), start_ns + 3 * kMs);
}

TEST_F(MemoryEndpointTest, LosesDuplicatesAndReordersTheRequestedShares) {
  open({.seed = 5, .loss = 0.2, .duplicate = 0.1, .reorder = 0.1, .reorder_by_ns = 10 * kMs});
  constexpr int kSent = 10'000;
  std::vector<int> numbers;
  int backwards = 0;
  for (int i = 0; i < kSent; ++i) {
    send(static_cast<std::uint8_t>(i));
    for (const int number : receive_all(kMs)) {
      backwards += !numbers.empty() && static_cast<std::uint8_t>(number - numbers.back()) > 128 ? 1 : 0;
      numbers.push_back(number);
    }
  }
  EXPECT_NEAR(static_cast<double>(numbers.size()), 0.8 * 1.1 * kSent, 0.02 * kSent);
  EXPECT_GT(backwards, kSent / 50);
}

TEST_F(MemoryEndpointTest, TheSameSeedGivesTheSameNetwork) {
  std::vector<std::vector<int>> runs;
  for (const std::uint64_t seed : {3U, 3U, 4U}) {
    open({.seed = seed, .loss = 0.3, .duplicate = 0.2, .jitter_ns = 5 * kMs});
    for (int i = 0; i < 100; ++i) {
      send(static_cast<std::uint8_t>(i));
    }
    runs.push_back(receive_all(50 * kMs));
    a_.reset();
    b_.reset();
  }
  EXPECT_EQ(runs[0], runs[1]);
  EXPECT_NE(runs[0], runs[2]);
}

TEST_F(MemoryEndpointTest, AnAddressIsHeldOnceAndFreedByClosing) {
  open();
  EXPECT_FALSE(network_->open(memory_address(1, 100)));
  a_.reset();
  EXPECT_TRUE(network_->open(memory_address(1, 100)));
  const auto any = network_->open(memory_address(1, 0));
  ASSERT_TRUE(any);
  EXPECT_EQ((*any)->local_address().port, 49152);
  const auto next = network_->open(memory_address(1, 0));
  ASSERT_TRUE(next);
  EXPECT_EQ((*next)->local_address().port, 49153) << "the first free one";
}

TEST_F(MemoryEndpointTest, SendingWithoutAReceiverIsNoError) {
  open();
  b_.reset();
  const std::array<std::byte, 1> bytes = {};
  EXPECT_TRUE(a_->send(memory_address(2, 100), bytes));
}

}  // namespace
}  // namespace hapton
