#include "core/effects/sampled_motion.h"

#include <gtest/gtest.h>

#include <limits>

namespace hapton {
namespace {

constexpr double kSampleS = 1e-3;

// Adds this number of samples of a motion from x_m along x at this speed.
void add_samples(SampledMotion& motion, double& x_m, double m_per_s, int samples) {
  for (int n = 0; n < samples; ++n) motion.add(Vec3(x_m += kSampleS * m_per_s, 0, 0), kSampleS);
}

TEST(SampledMotion, IsThatOfSteadySamples) {
  SampledMotion motion;
  double x_m = 0.3;
  motion.add(Vec3(x_m, 0, 0), 0.0);
  EXPECT_EQ(motion.velocity(), Vec3::Zero());
  add_samples(motion, x_m, 0.1, 8);
  EXPECT_NEAR(motion.velocity().x(), 0.1, 1e-12);
}

// Samples of another hub, or of one whose machine has restarted: meanwhile the hand has moved by 0.1 m in an unknown time.
TEST(SampledMotion, BeginsAnewWhereTheClockStepsBack) {
  SampledMotion motion;
  double x_m = 0.0;
  motion.add(Vec3(x_m, 0, 0), 0.0);
  add_samples(motion, x_m, 0.1, 20);
  motion.add(Vec3(x_m += 0.1, 0, 0), -1000.0);
  EXPECT_EQ(motion.velocity(), Vec3::Zero());
  for (int n = 0; n < 20; ++n) {
    add_samples(motion, x_m, 0.05, 1);
    EXPECT_LE(motion.velocity().x(), 0.05 + 1e-9) << n;
    EXPECT_GE(motion.velocity().x(), 0.0) << n;
  }
  EXPECT_NEAR(motion.velocity().x(), 0.05, 1e-9);
}

TEST(SampledMotion, CountsTheTimeOfSamplesWithoutAPlace) {
  SampledMotion motion;
  const Vec3 nowhere = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  double x_m = 0.0;
  motion.add(nowhere, 0.0);
  motion.add(Vec3(x_m, 0, 0), kSampleS);
  add_samples(motion, x_m, 0.1, 8);
  for (int n = 0; n < 10; ++n) motion.add(nowhere, kSampleS);
  motion.add(Vec3(x_m += 11 * kSampleS * 0.1, 0, 0), kSampleS);
  EXPECT_NEAR(motion.velocity().x(), 0.1, 1e-9);
  motion.add(nowhere, -1.0);
  EXPECT_EQ(motion.velocity(), Vec3::Zero());
  motion.add(Vec3(5, 0, 0), kSampleS);
  EXPECT_EQ(motion.velocity(), Vec3::Zero()) << "the first place since the clock stepped back";
}

}  // namespace
}  // namespace hapton
