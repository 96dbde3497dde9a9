#include "runtime/handoff_ring.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <thread>

namespace hapton {
namespace {

TEST(HandoffRingTest, HandsOverInOrderAndTakesNoMoreThanItHolds) {
  HandoffRing<int, 4> ring;
  int item = 0;
  EXPECT_FALSE(ring.pop(item));
  for (int n = 1; n <= 4; ++n) EXPECT_TRUE(ring.push(n));
  EXPECT_FALSE(ring.push(5));
  EXPECT_TRUE(ring.pop(item));
  EXPECT_EQ(item, 1);
  EXPECT_TRUE(ring.push(5));
  for (int n = 2; n <= 5; ++n) {
    EXPECT_TRUE(ring.pop(item));
    EXPECT_EQ(item, n);
  }
  EXPECT_FALSE(ring.pop(item));
}

TEST(HandoffRingTest, TwoThreadsLoseAndDoubleNothing) {
  constexpr std::uint64_t kItems = 200'000;
  HandoffRing<std::uint64_t, 16> ring;
  std::thread writer([&] {
    for (std::uint64_t n = 1; n <= kItems; ++n) {
      while (!ring.push(n)) std::this_thread::yield();
    }
  });
  std::uint64_t item = 0;
  for (std::uint64_t n = 1; n <= kItems; ++n) {
    while (!ring.pop(item)) std::this_thread::yield();
    ASSERT_EQ(item, n);
  }
  writer.join();
}

struct SecretItem {
  std::uint64_t value = 0;
  const void* at = nullptr;
};

TEST(HandoffRingTest, NothingStaysBehindInASlot) {
  HandoffRing<SecretItem, 2> ring;
  ring.push({0x1122334455667788U, nullptr});
  SecretItem item;
  ring.pop(item);
  EXPECT_EQ(item.value, 0x1122334455667788U);
  const auto* words = reinterpret_cast<const std::uint64_t*>(&ring);
  for (std::size_t n = 0; n < sizeof ring / sizeof *words; ++n) EXPECT_NE(words[n], item.value);
}

}  // namespace
}  // namespace hapton
