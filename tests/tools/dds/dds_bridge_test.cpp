#include "tools/dds/dds_bridge.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton::dds {
namespace {

constexpr std::int64_t kBridgeMs = 1'000'000;

ProbeState probe_at(std::uint64_t sample) {
  ProbeState probe;
  probe.sample = sample;
  probe.sample_time_ns = static_cast<std::int64_t>(sample) * kBridgeMs;
  const double t_s = 1e-3 * static_cast<double>(sample);
  probe.p_WD = Vec3(0.3 * t_s, -0.1 * t_s, 0.0);
  probe.q_WT = Quat(Eigen::AngleAxisd(2.0 * t_s, Vec3::UnitY()));
  return probe;
}

TEST(SampleMaker, VelocitiesAreThoseOfTheMotion) {
  SampleMaker maker(true);
  std::optional<RosSample> sample;
  for (std::uint64_t i = 1; i <= 20; ++i) sample = maker.make(probe_at(i), 1, static_cast<std::int64_t>(i) * kBridgeMs, 0);
  ASSERT_TRUE(sample);
  EXPECT_LT((sample->linear_m_per_s - Vec3(0.3, -0.1, 0.0)).norm(), 1e-9);
  EXPECT_LT((sample->angular_rad_per_s - Vec3(0.0, 2.0, 0.0)).norm(), 1e-6);
  EXPECT_EQ(sample->stamp_ns, 20 * kBridgeMs);
}

TEST(SampleMaker, ASampleCountsOnceAndGapsAreCounted) {
  SampleMaker maker(true);
  EXPECT_TRUE(maker.make(probe_at(5), 1, 0, 0));
  EXPECT_FALSE(maker.make(probe_at(5), 1, 0, 0));
  EXPECT_FALSE(maker.make(probe_at(4), 1, 0, 0));
  EXPECT_EQ(maker.skipped(), 0U);
  const auto later = maker.make(probe_at(25), 1, 0, 0);
  ASSERT_TRUE(later);
  EXPECT_EQ(maker.skipped(), 19U);
}

TEST(SampleMaker, AnotherSessionBeginsAnew) {
  SampleMaker maker(true);
  for (std::uint64_t i = 100; i <= 120; ++i) maker.make(probe_at(i), 1, 0, 0);
  const auto first = maker.make(probe_at(1), 2, 0, 0);
  ASSERT_TRUE(first);
  EXPECT_TRUE(first->linear_m_per_s.isZero(0.0));
  EXPECT_TRUE(first->angular_rad_per_s.isZero(0.0));
  EXPECT_GT(first->stamp_ns, 120 * kBridgeMs);
  EXPECT_EQ(maker.skipped(), 0U);
}

}  // namespace
}  // namespace hapton::dds
