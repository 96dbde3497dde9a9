#include "io_node/event_ring.h"

#include <gtest/gtest.h>

#include <thread>

namespace hapton {
namespace {

TEST(EventRing, HandsOverInOrderBetweenThreadsAndCountsWhatItDrops) {
  EventRing ring;
  constexpr int kEvents = 100'000;
  std::thread writer([&] {
    for (int n = 1; n <= kEvents; ++n) ring.push({ServoEvent::Kind::rate_changed, NodeRole::tool, {}, static_cast<double>(n), {}});
  });
  double last = 0.0;
  std::uint64_t popped = 0;
  const auto drain = [&] {
    for (ServoEvent event; ring.pop(event); ++popped) {
      ASSERT_GT(event.rate_hz, last);
      last = event.rate_hz;
    }
  };
  while (popped + ring.dropped() < kEvents) drain();
  writer.join();
  EXPECT_EQ(popped + ring.dropped(), static_cast<std::uint64_t>(kEvents));
}

TEST(EventRing, FullDropsTheNewest) {
  EventRing ring;
  for (int n = 0; n < 70; ++n) ring.push({ServoEvent::Kind::rate_changed, NodeRole::tool, {}, static_cast<double>(n), {}});
  EXPECT_EQ(ring.dropped(), 6U);
  ServoEvent event;
  ASSERT_TRUE(ring.pop(event));
  EXPECT_EQ(event.rate_hz, 0.0);
}

}  // namespace
}  // namespace hapton
