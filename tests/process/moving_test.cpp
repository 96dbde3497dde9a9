// Objects that move by keyframes, in the real programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/process/led_hand.h"

namespace hapton::process {
namespace {

using ::testing::HasSubstr;

// A hand that holds still over the piston of scenes/machine.toml is pushed up by it; the recording gives the same forces again.
TEST(MovingObjects, PushAHandThatHoldsStillAndAreReplayed) {
  LedHand hand("simulated", "t_s,x_m,y_m,z_m\n0,-0.068,0.05,0\n0.5,-0.068,0.033,0\n60,-0.068,0.033,0\n", "machine.toml");
  EXPECT_TRUE(hand.goes_above("max_force_written_n", 0.5));
  hand.end();
  const Ended replayed = hand.replay();
  EXPECT_EQ(replayed.exit_code, 0) << replayed.out << replayed.err;
  EXPECT_THAT(replayed.out, HasSubstr(" 0 different"));
}

}  // namespace
}  // namespace hapton::process
