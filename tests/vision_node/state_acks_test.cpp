#include "vision_node/state_acks.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

using AckKind = StateAcks::Kind;

TEST(StateAcks, TheFirstFrameWithAStateAcknowledgesIt) {
  StateAcks acks;
  EXPECT_EQ(acks.note(5 * kMs, 9 * kMs), AckKind::first);
  EXPECT_EQ(acks.note(5 * kMs, 25 * kMs), AckKind::none);
  EXPECT_EQ(acks.note(26 * kMs, 30 * kMs), AckKind::first);
  EXPECT_EQ(acks.note(26 * kMs, 30 * kMs + StateAcks::kRepeatPeriodNs - 1), AckKind::none) << "counted from the newest";
}

// An acknowledgement may be lost.
TEST(StateAcks, LaterFramesAcknowledgeItAgainButNotEach) {
  StateAcks acks;
  EXPECT_EQ(acks.note(5 * kMs, 9 * kMs), AckKind::first);
  int again = 0;
  for (std::int64_t n = 1; n <= 60; ++n) {
    const AckKind kind = acks.note(5 * kMs, 9 * kMs + n * 16'666'667);
    ASSERT_NE(kind, AckKind::first) << n;
    again += kind == AckKind::repeat ? 1 : 0;
  }
  EXPECT_EQ(again, 30) << "every second frame at 60 Hz";
}

}  // namespace
}  // namespace hapton
