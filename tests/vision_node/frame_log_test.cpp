#include "vision_node/frame_log.h"

#include <cstdio>

#include <gtest/gtest.h>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(FrameLog, RateLeavesOutThePauses) {
  FrameLog log;
  std::int64_t now = 0;
  for (int burst = 0; burst < 5; ++burst) {
    for (int i = 0; i < 50; ++i, now += 20 * kMs) log.record_frame(now, now + 10 * kMs);
    now += 10'000 * kMs;
  }
  EXPECT_EQ(log.drawn(), 250u);
  EXPECT_NEAR(log.rate_hz(), 50.0, 0.01);
  EXPECT_NEAR(log.recent_rate_hz(), 50.0, 0.01);
  EXPECT_NEAR(log.draw_time().quantile_ns(0.5) * 1e-6, 10.0, 0.1);
}

TEST(FrameLog, SlowPicturesAreNoPause) {
  FrameLog log;
  for (std::int64_t i = 0; i < 5; ++i) log.record_frame(i * 1000 * kMs, i * 1000 * kMs + 900 * kMs);
  EXPECT_NEAR(log.rate_hz(), 1.0, 1e-6);
}

TEST(FrameLog, SaysHowOldTheProbeIsInMillisecondsAndFramesAndHowLongTheFirstFrameTook) {
  FrameLog log;
  EXPECT_EQ(log.describe_motion(), "");
  log.record_frame(0, 80 * kMs);
  for (std::int64_t i = 1; i < 200; ++i) {
    log.record_frame(80 * kMs + i * 20 * kMs, 90 * kMs + i * 20 * kMs);
    log.record_motion_to_photon(i < 195 ? 10 * kMs : 26 * kMs);
  }
  double p50_ms = 0.0, p99_ms = 0.0, p50_frames = 0.0, p99_frames = 0.0;
  ASSERT_EQ(std::sscanf(log.describe_motion().c_str(), "motion to photon p50 %lf ms p99 %lf ms (%lf, %lf frames)", &p50_ms, &p99_ms,
                        &p50_frames, &p99_frames),
            4)
      << log.describe_motion();
  EXPECT_NEAR(p50_ms, 10.0, 0.2);
  EXPECT_NEAR(p99_ms, 26.0, 0.5);
  EXPECT_NEAR(p50_frames, 0.5, 0.02);
  EXPECT_NEAR(p99_frames, 1.3, 0.05);
  EXPECT_NE(log.describe().find("the first 80 ms"), std::string::npos) << log.describe();
}

TEST(FrameLog, WithoutFramesAllNumbersAreZero) {
  const FrameLog log;
  EXPECT_EQ(log.rate_hz(), 0.0);
  EXPECT_EQ(log.recent_rate_hz(), 0.0);
  EXPECT_NE(log.describe().find("drawn 0"), std::string::npos);
}

}  // namespace
}  // namespace hapton
