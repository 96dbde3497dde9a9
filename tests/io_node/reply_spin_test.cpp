#include "io_node/reply_spin.h"

#include <gtest/gtest.h>

#include "tests/io_node/network_loop_fixture.h"
#include "tests/support/ticking_clock.h"

namespace hapton {
namespace {

TEST(ReplySpin, LastsAsLongAsRequestedAndNoLongerThanItsShareOfAPeriod) {
  ReplySpin spin(100 * kUs);
  EXPECT_EQ(spin.find_end_ns(7, kMs), 7 + 100 * kUs);
  EXPECT_EQ(spin.find_end_ns(7, 100 * kUs), 7 + 50 * kUs);
  spin.set_limit(0.01);
  EXPECT_EQ(spin.find_end_ns(7, kMs), 7 + 10 * kUs);
  spin.set_limit(0.0);
  EXPECT_EQ(spin.find_end_ns(7, kMs), 7);
  EXPECT_EQ(ReplySpin().find_end_ns(7, kMs), 7);
}

struct SpinningNetworkLoops : NetworkLoops {
  TickingClock ticking{clock};

  void run_with(std::int64_t reply_ns, int cycles) {
    reply_delay_ns = reply_ns;
    network = std::make_unique<NetworkLoop>(device, peers, ticking, NetworkLoop::Options{.reply_spin_ns = 150 * kUs});
    join(kHaptics, NodeRole::haptics);
    run(cycles);
  }
};

TEST_F(SpinningNetworkLoops, SpinUntilTheForceIsThere) {
  run_with(100 * kUs, 500);
  EXPECT_GT(network->collect_stats().forces, 450U);
  EXPECT_GT(network->reply_spin().spun_ns(), 450 * 90 * kUs);
  EXPECT_LT(network->reply_spin().spun_ns(), 500 * 110 * kUs);
}

TEST_F(SpinningNetworkLoops, SleepForAForceThatComesLaterThanThat) {
  run_with(300 * kUs, 500);
  EXPECT_GT(network->collect_stats().forces, 450U);
  // No force comes during a spin of 150 us, so only the waits of one SpinTrial spin; all later ones sleep.
  EXPECT_GT(network->reply_spin().spun_ns(), SpinTrial::kWaits * 140 * kUs);
  EXPECT_LT(network->reply_spin().spun_ns(), SpinTrial::kWaits * 160 * kUs);
}

}  // namespace
}  // namespace hapton
