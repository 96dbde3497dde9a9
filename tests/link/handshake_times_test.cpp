#include "link/handshake_times.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

constexpr KeyRole kRole = KeyRole::vision;

TEST(HandshakeTimesTest, TakesEachLaterOneOnce) {
  HandshakeTimes times;
  EXPECT_TRUE(times.accept(kRole, 1, 100));
  EXPECT_FALSE(times.accept(kRole, 1, 100));
  EXPECT_FALSE(times.accept(kRole, 1, 99));
  EXPECT_TRUE(times.accept(kRole, 1, 101));
  EXPECT_FALSE(times.accept(kRole, 1, std::numeric_limits<std::int64_t>::min()));
}

TEST(HandshakeTimesTest, HostsAndRolesHaveTimesOfTheirOwn) {
  HandshakeTimes times;
  EXPECT_TRUE(times.accept(kRole, 1, 100));
  EXPECT_TRUE(times.accept(kRole, 2, 50));
  EXPECT_TRUE(times.accept(kRole, 0, 1));
  EXPECT_TRUE(times.accept(KeyRole::tool, 1, 100));
  EXPECT_FALSE(times.accept(kRole, 1, 100));
}

TEST(HandshakeTimesTest, AnyTimeMayBeTheFirst) {
  for (const std::int64_t first :
       {std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}, std::int64_t{0}, std::numeric_limits<std::int64_t>::max()}) {
    HandshakeTimes times;
    EXPECT_TRUE(times.accept(kRole, 7, first));
    EXPECT_FALSE(times.accept(kRole, 7, first));
  }
}

TEST(HandshakeTimesTest, ManyHostsDisplaceTheOldestOfTheirOwnRoleOnly) {
  HandshakeTimes times;
  EXPECT_TRUE(times.accept(KeyRole::haptics, 1, 100));
  EXPECT_TRUE(times.accept(kRole, 1, 100));
  EXPECT_TRUE(times.accept(kRole, 2, 100));
  EXPECT_TRUE(times.accept(kRole, 1, 101));
  for (std::uint64_t host = 3; host <= HandshakeTimes::kHosts + 1; ++host) EXPECT_TRUE(times.accept(kRole, host, 100));
  EXPECT_TRUE(times.accept(kRole, 2, 100)) << "host 2 was the oldest, and made room";
  EXPECT_FALSE(times.accept(KeyRole::haptics, 1, 100));
}

}  // namespace
}  // namespace hapton
