#include "remote_touch/effective_offset.h"

#include <gtest/gtest.h>

#include <cmath>

namespace hapton {
namespace {

constexpr double kPeriodS = 1e-3;
constexpr std::size_t kMaxLate = 60;
constexpr double kStepCost = 0.02;

Vec3 sway(double t_s) { return {1.0 + 0.5 * std::sin(9.0 * t_s), 0.3 * std::sin(23.0 * t_s), 0.0}; }

std::vector<Vec3> sample(double late_s, const Vec3& added) {
  std::vector<Vec3> values;
  for (int i = 0; i < 2000; ++i) values.push_back(sway(std::max(kPeriodS * i - late_s, 0.0)) + added);
  return values;
}

EffectiveOffset find(const std::vector<Vec3>& signal) {
  return find_effective_offset(signal, sample(0.0, Vec3::Zero()), kPeriodS, kMaxLate, kStepCost, 1e-3);
}

TEST(EffectiveOffset, OfTheSameSignalIsZero) {
  const EffectiveOffset offset = find(sample(0.0, Vec3::Zero()));
  EXPECT_EQ(offset.time_s, 0.0);
  EXPECT_EQ(offset.value, 0.0);
}

TEST(EffectiveOffset, ALateSignalIsLateAndNotWrong) {
  for (const double late_s : {0.005, 0.03}) {
    const EffectiveOffset offset = find(sample(late_s, Vec3::Zero()));
    EXPECT_NEAR(offset.time_s, late_s, 1e-3);
    EXPECT_NEAR(offset.value, 0.0, 1e-3);
  }
}

TEST(EffectiveOffset, AWrongSignalIsWrongAndNotLate) {
  const Vec3 added(0.0, 0.0, 0.1);
  const EffectiveOffset offset = find(sample(0.0, added));
  EXPECT_NEAR(offset.time_s, 0.0, 1e-3);
  EXPECT_NEAR(offset.value, 0.1, 1e-3);
}

TEST(EffectiveOffset, BothAreDistinguished) {
  const EffectiveOffset offset = find(sample(0.02, Vec3(0.0, 0.0, 0.1)));
  EXPECT_NEAR(offset.time_s, 0.02, 2e-3);
  EXPECT_NEAR(offset.value, 0.1, 5e-3);
}

TEST(EffectiveOffset, MeansAreOverWhatIsNotSilent) {
  std::vector<Vec3> reference(3000, Vec3::Zero());
  std::vector<Vec3> signal(3000, Vec3::Zero());
  for (std::size_t i = 1000; i < 2000; ++i) {
    const double t_s = kPeriodS * static_cast<double>(i);
    reference[i] = sway(t_s);
    signal[i] = sway(t_s) + Vec3(0.0, 0.0, 0.1);
  }
  EXPECT_NEAR(find_effective_offset(signal, reference, kPeriodS, kMaxLate, kStepCost, 1e-3).value, 0.1, 1e-3);
  EXPECT_EQ(find_effective_offset({}, {}, kPeriodS, kMaxLate, kStepCost, 1e-3).time_s, 0.0);
}

}  // namespace
}  // namespace hapton
