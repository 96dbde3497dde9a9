#include "runtime/adaptive_spin.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hapton {
namespace {

constexpr std::int64_t kPeriodNs = 1'000'000;

TEST(AdaptiveSpin, WithoutALimitOfItsOwnItNeverSpins) {
  AdaptiveSpin spin;
  for (int n = 0; n < 100; ++n) spin.note_wake_up(50'000);
  EXPECT_EQ(spin.margin_ns(kPeriodNs), 0);
}

TEST(AdaptiveSpin, TheMarginSettlesWhereOneWakeUpInAHundredIsLater) {
  std::mt19937_64 random(7);
  std::exponential_distribution<double> lateness(1.0 / 20'000.0);
  AdaptiveSpin spin(0.5);
  int later_count = 0;
  constexpr int kWakeUps = 100'000;
  for (int n = 0; n < 2 * kWakeUps; ++n) {
    const auto late_ns = static_cast<std::int64_t>(lateness(random));
    later_count += n >= kWakeUps && late_ns > spin.margin_ns(kPeriodNs) ? 1 : 0;
    spin.note_wake_up(late_ns);
  }
  EXPECT_NEAR(static_cast<double>(later_count) / kWakeUps, 0.01, 0.002);
  EXPECT_NEAR(static_cast<double>(spin.margin_ns(kPeriodNs)), 20'000.0 * std::log(100.0), 30'000.0);
}

TEST(AdaptiveSpin, ItTakesNoMoreThanItsShare) {
  AdaptiveSpin spin(0.1);
  for (int n = 0; n < 1000; ++n) spin.note_wake_up(500'000);
  EXPECT_EQ(spin.margin_ns(kPeriodNs), 100'000);
  EXPECT_EQ(spin.margin_ns(100'000), 10'000);
  spin.set_limit(0.0);
  EXPECT_EQ(spin.margin_ns(kPeriodNs), 0);
}

TEST(AdaptiveSpin, AMachineThatWakesInTimeIsNotSpunFor) {
  AdaptiveSpin spin(0.1);
  for (int n = 0; n < 20; ++n) spin.note_wake_up(30'000);
  for (int n = 0; n < 5000; ++n) spin.note_wake_up(0);
  EXPECT_EQ(spin.margin_ns(kPeriodNs), 0);
}

TEST(AdaptiveSpin, AddsUpWhatWasSpun) {
  AdaptiveSpin spin(0.1);
  spin.note_spun(5);
  spin.note_spun(6);
  EXPECT_EQ(spin.spun_ns(), 11);
}

}  // namespace
}  // namespace hapton
