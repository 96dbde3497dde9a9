#include "remote_touch/network_path.h"

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(NetworkPath, WhatIsSentComesAfterItsDelayInOrder) {
  NetworkPath<int> path({.delay_ns = 5 * kMs}, 1);
  path.send(1, 100, 0);
  path.send(2, 50, 0);
  path.send(3, 100, 1 * kMs);
  EXPECT_FALSE(path.receive(5 * kMs - 1));
  EXPECT_EQ(path.receive(5 * kMs), 1);
  EXPECT_EQ(path.receive(5 * kMs), 2) << "sent later, due at the same time: in the order of sending";
  EXPECT_FALSE(path.receive(5 * kMs));
  EXPECT_EQ(path.receive(6 * kMs), 3);
  EXPECT_EQ(path.traffic().packets, 3U);
  EXPECT_EQ(path.traffic().bytes, 250U);
}

TEST(NetworkPath, WithoutDelayItComesAtOnce) {
  NetworkPath<int> path({}, 1);
  path.send(7, 1, 3 * kMs);
  EXPECT_EQ(path.receive(3 * kMs), 7);
}

TEST(NetworkPath, WhatIsLostNeverComesAndIsCountedAsSent) {
  NetworkPath<int> path({.loss = 0.3}, 1);
  int received = 0;
  for (int i = 0; i < 10000; ++i) {
    path.send(i, 1, i);
    received += path.receive(i) ? 1 : 0;
  }
  EXPECT_NEAR(received, 7000, 200);
  EXPECT_EQ(path.traffic().packets, 10000U);
}

TEST(NetworkPath, JitterAboveTheTimeBetweenTwoPacketsReordersThem) {
  NetworkPath<int> path({.delay_ns = kMs, .jitter_ns = 20 * kMs}, 1);
  int newest = -1;
  int overtaken = 0;
  for (int i = 0; i < 1000; ++i) {
    path.send(i, 1, i * kMs);
    while (const auto value = path.receive(i * kMs)) {
      overtaken += *value < newest ? 1 : 0;
      newest = std::max(newest, *value);
    }
  }
  EXPECT_GT(overtaken, 100);
}

}  // namespace
}  // namespace hapton
