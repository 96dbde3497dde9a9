#include "vision_node/frame_log.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

constexpr std::int64_t kMs = 1'000'000;

TEST(FrameLog, RateLeavesOutThePauses) {
  FrameLog log;
  std::int64_t now = 0;
  for (int burst = 0; burst < 5; ++burst) {
    for (int i = 0; i < 50; ++i, now += 20 * kMs) log.drew(now, now + 10 * kMs);
    now += 10'000 * kMs;
  }
  EXPECT_EQ(log.drawn(), 250u);
  EXPECT_NEAR(log.rate_hz(), 50.0, 0.01);
  EXPECT_NEAR(log.recent_rate_hz(), 50.0, 0.01);
  EXPECT_NEAR(log.draw_time().quantile_ns(0.5) * 1e-6, 10.0, 0.1);
}

TEST(FrameLog, SlowPicturesAreNoPause) {
  FrameLog log;
  for (std::int64_t i = 0; i < 5; ++i) log.drew(i * 1000 * kMs, i * 1000 * kMs + 900 * kMs);
  EXPECT_NEAR(log.rate_hz(), 1.0, 1e-6);
}

TEST(FrameLog, NothingDrawnIsZeroNotRubbish) {
  const FrameLog log;
  EXPECT_EQ(log.rate_hz(), 0.0);
  EXPECT_EQ(log.recent_rate_hz(), 0.0);
  EXPECT_NE(log.describe().find("drawn 0"), std::string::npos);
}

}  // namespace
}  // namespace hapton
