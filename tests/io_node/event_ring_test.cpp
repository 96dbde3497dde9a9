#include "io_node/event_ring.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

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
  EXPECT_EQ(ring.dropped(), 14U) << "56 slots, and 8 more that only faults may use";
  ServoEvent event;
  ASSERT_TRUE(ring.pop(event));
  EXPECT_EQ(event.rate_hz, 0.0);
}

// A node that may change the rate can flood the ring with changes; the latch file must still learn of a latched fault.
TEST(EventRing, ALatchedFaultAndItsResetFitWhereNothingElseDoes) {
  EventRing ring;
  for (int n = 0; n < 70; ++n) ring.push({ServoEvent::Kind::rate_changed, NodeRole::tool, {}, static_cast<double>(n), {}});
  ring.push({ServoEvent::Kind::latched, NodeRole::tool, {}, 0.0, {}, SafetyFault::jump});
  ring.push({ServoEvent::Kind::rate_changed, NodeRole::tool, {}, 70.0, {}});
  ring.push({ServoEvent::Kind::reset, NodeRole::tool, {}, 0.0, {}, SafetyFault::jump});
  std::vector<ServoEvent::Kind> kinds;
  for (ServoEvent event; ring.pop(event);) kinds.push_back(event.kind);
  ASSERT_EQ(kinds.size(), 58U);
  EXPECT_EQ(kinds[56], ServoEvent::Kind::latched);
  EXPECT_EQ(kinds[57], ServoEvent::Kind::reset);
}

}  // namespace
}  // namespace hapton
