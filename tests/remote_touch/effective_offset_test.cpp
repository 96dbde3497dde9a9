#include "remote_touch/effective_offset.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

constexpr double kPeriodS = 1e-3;
constexpr std::size_t kMaxDelaySamples = 60;
constexpr double kStepCost = 0.02;
constexpr double kMinNorm = 1e-3;

Vec3 signal_at(double t_s) { return {1.0 + 0.5 * std::sin(9.0 * t_s), 0.3 * std::sin(23.0 * t_s), 0.0}; }

std::vector<Vec3> delayed_samples(double late_s, const Vec3& added) {
  std::vector<Vec3> values;
  for (int i = 0; i < 2000; ++i) values.push_back(signal_at(std::max(kPeriodS * i - late_s, 0.0)) + added);
  return values;
}

EffectiveOffset find_offset(const std::vector<Vec3>& signal) {
  return find_effective_offset(signal, delayed_samples(0.0, Vec3::Zero()), kPeriodS, kMaxDelaySamples, kStepCost, kMinNorm);
}

TEST(EffectiveOffset, OfTheSameSignalIsZero) {
  const EffectiveOffset offset = find_offset(delayed_samples(0.0, Vec3::Zero()));
  EXPECT_EQ(offset.time_s, 0.0);
  EXPECT_EQ(offset.value, 0.0);
}

TEST(EffectiveOffset, ALateSignalIsLateAndNotWrong) {
  for (const double late_s : {0.005, 0.03}) {
    const EffectiveOffset offset = find_offset(delayed_samples(late_s, Vec3::Zero()));
    EXPECT_NEAR(offset.time_s, late_s, 1e-3);
    EXPECT_NEAR(offset.value, 0.0, 1e-3);
  }
}

TEST(EffectiveOffset, AWrongSignalIsWrongAndNotLate) {
  const Vec3 added(0.0, 0.0, 0.1);
  const EffectiveOffset offset = find_offset(delayed_samples(0.0, added));
  EXPECT_NEAR(offset.time_s, 0.0, 1e-3);
  EXPECT_NEAR(offset.value, 0.1, 1e-3);
}

TEST(EffectiveOffset, BothAreDistinguished) {
  const EffectiveOffset offset = find_offset(delayed_samples(0.02, Vec3(0.0, 0.0, 0.1)));
  EXPECT_NEAR(offset.time_s, 0.02, 2e-3);
  EXPECT_NEAR(offset.value, 0.1, 5e-3);
}

TEST(EffectiveOffset, MeansAreOverSamplesThatAreNotZero) {
  std::vector<Vec3> reference(3000, Vec3::Zero());
  std::vector<Vec3> signal(3000, Vec3::Zero());
  for (std::size_t i = 1000; i < 2000; ++i) {
    const double t_s = kPeriodS * static_cast<double>(i);
    reference[i] = signal_at(t_s);
    signal[i] = signal_at(t_s) + Vec3(0.0, 0.0, 0.1);
  }
  EXPECT_NEAR(find_effective_offset(signal, reference, kPeriodS, kMaxDelaySamples, kStepCost, kMinNorm).value, 0.1, 1e-3);
  EXPECT_EQ(find_effective_offset({}, {}, kPeriodS, kMaxDelaySamples, kStepCost, kMinNorm).time_s, 0.0);
}

}  // namespace
}  // namespace hapton
