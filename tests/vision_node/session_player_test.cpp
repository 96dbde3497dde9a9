#include "vision_node/session_player.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

TEST(SessionPlayer, PlaysWithTheClockAtTheChosenSpeedAndStopsAtTheEnd) {
  SessionPlayer player(10.0, 14.0);
  EXPECT_FALSE(player.advance(1'000'000'000)) << "the clock was not known before";
  EXPECT_TRUE(player.advance(1'500'000'000));
  EXPECT_DOUBLE_EQ(player.moment_s(), 10.5);
  player.speed_up();
  EXPECT_DOUBLE_EQ(player.speed(), 2.0);
  player.advance(2'500'000'000);
  EXPECT_DOUBLE_EQ(player.moment_s(), 12.5);
  player.advance(9'000'000'000);
  EXPECT_DOUBLE_EQ(player.moment_s(), 14.0);
  EXPECT_TRUE(player.is_paused());
  player.toggle_pause();
  EXPECT_DOUBLE_EQ(player.moment_s(), 10.0) << "from the beginning";
}

TEST(SessionPlayer, PausesAndIsHeld) {
  SessionPlayer player(0.0, 4.0);
  player.advance(0);
  player.toggle_pause();
  EXPECT_FALSE(player.advance(1'000'000'000));
  player.toggle_pause();
  player.hold(true);
  EXPECT_FALSE(player.advance(2'000'000'000));
  player.hold(false);
  EXPECT_TRUE(player.advance(2'250'000'000));
  EXPECT_DOUBLE_EQ(player.moment_s(), 0.25) << "the pause is left out";
}

TEST(SessionPlayer, SpeedsAreFromATenthToEight) {
  SessionPlayer player(0.0, 4.0);
  for (int i = 0; i < 9; ++i) player.speed_up();
  EXPECT_DOUBLE_EQ(player.speed(), 8.0);
  for (int i = 0; i < 9; ++i) player.slow_down();
  EXPECT_DOUBLE_EQ(player.speed(), 0.1);
  player.set_speed(3.0);
  player.speed_up();
  EXPECT_DOUBLE_EQ(player.speed(), 4.0);
  player.set_speed(3.0);
  player.slow_down();
  EXPECT_DOUBLE_EQ(player.speed(), 2.0);
}

TEST(SessionPlayer, SeeksWithinTheRecordingOnly) {
  SessionPlayer player(1.0, 4.0);
  player.seek(2.5);
  EXPECT_DOUBLE_EQ(player.moment_s(), 2.5);
  player.seek(99.0);
  EXPECT_DOUBLE_EQ(player.moment_s(), 4.0);
  player.seek(-99.0);
  EXPECT_DOUBLE_EQ(player.moment_s(), 1.0);
  player.seek(std::numeric_limits<double>::quiet_NaN());
  EXPECT_DOUBLE_EQ(player.moment_s(), 1.0);
}

}  // namespace
}  // namespace hapton
