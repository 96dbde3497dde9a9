#include "closed_loop/velocity_estimator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using Kind = VelocityFilter::Kind;
constexpr double kPeriodS = 1e-3;
constexpr double kStepM = 3e-5;

// All estimators are right at a steady speed if the position is read exactly.
TEST(VelocityEstimators, AreExactAtASteadySpeedThatIsReadExactly) {
  std::set<std::string> names;
  for (const VelocityFilter& filter : velocity_filters()) {
    EXPECT_TRUE(names.insert(filter.name()).second);
    const auto estimator = make_velocity_estimator(filter, 0.0);
    estimator->reset(0.02);
    double velocity = 0.0;
    for (int k = 1; k <= 5000; ++k) velocity = estimator->step(0.02 - 0.037 * kPeriodS * k, kPeriodS);
    EXPECT_NEAR(velocity, -0.037, 1e-9) << filter.name();
  }
}

// A reset forgets all motion before it: the estimates are then those of a new estimator.
TEST(VelocityEstimators, AfterAResetNothingOfTheMotionBeforeCounts) {
  for (const VelocityFilter& filter : velocity_filters()) {
    const auto used = make_velocity_estimator(filter, kStepM);
    const auto fresh = make_velocity_estimator(filter, kStepM);
    used->reset(-0.1);
    for (int k = 1; k <= 50; ++k) used->step(-0.1 + 0.004 * k, 1.5 * kPeriodS);
    used->reset(0.02);
    fresh->reset(0.02);
    for (int k = 1; k <= 50; ++k) {
      const double position_m = 0.02 + 0.003 * std::sin(0.1 * k);
      ASSERT_EQ(used->step(position_m, kPeriodS), fresh->step(position_m, kPeriodS)) << filter.name() << ", sample " << k;
    }
  }
}

// The lags in closed form: half a period for the difference, and what a first-order low-pass adds to that.
TEST(VelocityEstimators, LagAsTheoryHasIt) {
  EXPECT_NEAR(measure_velocity({}, kPeriodS, 0.0).lag_s, 0.5 * kPeriodS, 1e-9);
  for (const double cutoff_hz : {20.0, 100.0}) {
    const double share = -std::expm1(-2.0 * std::numbers::pi * cutoff_hz * kPeriodS);
    const double expected = (0.5 + (1.0 - share) / share) * kPeriodS;
    EXPECT_NEAR(measure_velocity({Kind::first_order, cutoff_hz}, kPeriodS, 0.0).lag_s, expected, 1e-6) << cutoff_hz;
  }
  // The mean with the weights 8, 7 .. 1 lags by 7/3 periods, in addition to the half period of the difference.
  EXPECT_NEAR(measure_velocity({Kind::mean}, kPeriodS, 0.0).lag_s, (0.5 + 7.0 / 3.0) * kPeriodS, 1e-9);
}

// With encoder steps D, the difference is wrong by at most D/T, and by D/T sqrt(f (1 - f)) RMS where a share f of the periods sees one step
// more than the others: at most half of D/T.
TEST(VelocityEstimators, TheDifferencesNoiseIsThatOfItsEncoder) {
  const double noise = measure_velocity({}, kPeriodS, kStepM).noise_m_per_s;
  EXPECT_LE(noise, 0.5 * kStepM / kPeriodS * 1.01);
  EXPECT_GE(noise, 0.4 * kStepM / kPeriodS);
}

TEST(VelocityEstimators, AllButTheDifferenceTradeNoiseForLag) {
  const VelocityQuality difference = measure_velocity({}, kPeriodS, kStepM);
  for (const VelocityFilter& filter : velocity_filters()) {
    if (filter.kind == Kind::difference) continue;
    const VelocityQuality quality = measure_velocity(filter, kPeriodS, kStepM);
    EXPECT_LT(quality.noise_m_per_s, difference.noise_m_per_s) << filter.name();
    EXPECT_GT(quality.lag_s, 0.0) << filter.name();
  }
  // Of two filters of one kind, the one with less noise has at least as much lag.
  for (const auto& [fast, slow] : {std::pair(VelocityFilter{Kind::first_order, 100.0}, VelocityFilter{Kind::first_order, 20.0}),
                                   std::pair(VelocityFilter{Kind::adaptive, 8.0}, VelocityFilter{Kind::adaptive, 32.0}),
                                   std::pair(VelocityFilter{Kind::kalman, 30.0}, VelocityFilter{Kind::kalman, 3.0})}) {
    const VelocityQuality a = measure_velocity(fast, kPeriodS, kStepM);
    const VelocityQuality b = measure_velocity(slow, kPeriodS, kStepM);
    EXPECT_GT(a.noise_m_per_s, b.noise_m_per_s) << slow.name();
    EXPECT_LE(a.lag_s, b.lag_s) << slow.name();
  }
}

// By brute force: of all windows, the longest whose straight line passes every position within a step.
TEST(VelocityEstimators, TheAdaptiveWindowIsTheLongestThatHolds) {
  constexpr unsigned kSeed = 20261122;
  RecordProperty("seed", std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::uniform_int_distribution<int> steps(-2, 2);
  const auto estimator = make_velocity_estimator({Kind::adaptive, 16.0}, kStepM);
  std::vector<double> readings_m = {0.0};
  estimator->reset(0.0);
  for (int k = 1; k < 2000; ++k) {
    readings_m.push_back(readings_m.back() + (k % 300 < 150 ? steps(random) : 1) * kStepM);
    const double found = estimator->step(readings_m.back(), kPeriodS);
    double expected = 0.0;
    for (int n = 1; n <= std::min(16, k); ++n) {
      const double slope = (readings_m[k] - readings_m[k - n]) / n;
      bool holds = true;
      for (int i = 1; i < n; ++i) holds = holds && std::fabs(readings_m[k] - slope * i - readings_m[k - i]) <= kStepM * (1.0 + 1e-6);
      if (!holds) break;
      expected = slope / kPeriodS;
    }
    ASSERT_NEAR(found, expected, 1e-6 * kStepM / kPeriodS) << "sample " << k;
  }
}

// By brute force over the gain of a steady filter: on the motion for which the Kalman filter is made, none has an error 2 % smaller.
TEST(VelocityEstimators, TheKalmanFilterIsTheBestOfItsKind) {
  constexpr unsigned kSeed = 20261122;
  RecordProperty("seed", std::to_string(kSeed));
  constexpr double kAcceleration = 10.0;
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> push(0.0, kAcceleration);
  std::uniform_real_distribution<double> reading(-0.5 * kStepM, 0.5 * kStepM);
  std::vector<double> readings_m;
  std::vector<double> speed;
  double x = 0.0;
  double v = 0.0;
  for (int k = 0; k < 20'000; ++k) {
    const double a = push(random);
    x += v * kPeriodS + 0.5 * a * kPeriodS * kPeriodS;
    v += a * kPeriodS;
    readings_m.push_back(x + reading(random));
    speed.push_back(v);
  }
  const auto error_of = [&](const auto& step) {
    double sum = 0.0;
    for (std::size_t k = 0; k < readings_m.size(); ++k) {
      const double error = step(readings_m[k]) - speed[k];
      if (k > 1000) sum += error * error;
    }
    return sum;
  };
  const auto kalman = make_velocity_estimator({Kind::kalman, kAcceleration}, kStepM);
  kalman->reset(0.0);
  const double kalman_error = error_of([&](double position) { return kalman->step(position, kPeriodS); });
  for (double gain_x = 0.02; gain_x < 0.9; gain_x += 0.02) {
    // For a mass pushed by white noise, the gain of the position determines that of the velocity (Kalata 1984).
    const double root = std::sqrt(1.0 - gain_x);
    const double gain_v = (2.0 * (2.0 - gain_x) - 4.0 * root) / kPeriodS;
    double position_m = 0.0;
    double velocity = 0.0;
    const double other_error = error_of([&](double position) {
      position_m += velocity * kPeriodS;
      const double error = position - position_m;
      position_m += gain_x * error;
      velocity += gain_v * error;
      return velocity;
    });
    EXPECT_LE(kalman_error, 1.02 * other_error) << gain_x;
  }
}

TEST(VelocityEstimators, UseNoHeapInAStep) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  for (const VelocityFilter& filter : velocity_filters()) {
    const auto estimator = make_velocity_estimator(filter, kStepM);
    estimator->reset(0.0);
    const AllocationGuard guard;
    for (int k = 1; k < 500; ++k) estimator->step(1e-5 * k, kPeriodS);
    EXPECT_EQ(guard.count(), 0U) << filter.name();
  }
}

TEST(VelocityEstimators, TheChoiceIsTheLeastLagThatIsQuietEnough) {
  const std::vector<VelocityRow> rows = compare_velocity(kPeriodS, kStepM);
  ASSERT_EQ(rows.size(), velocity_filters().size());
  for (const double most_noise : {1.0, 0.010, 0.003, 0.001}) {
    const VelocityRow* chosen = choose_velocity(rows, most_noise);
    ASSERT_NE(chosen, nullptr);
    EXPECT_LE(chosen->quality.noise_m_per_s, most_noise);
    for (const VelocityRow& row : rows) {
      EXPECT_TRUE(row.quality.noise_m_per_s > most_noise || row.quality.lag_s >= chosen->quality.lag_s) << row.filter.name();
    }
  }
  EXPECT_EQ(choose_velocity(rows, 1.0)->filter.kind, Kind::difference);
  EXPECT_EQ(choose_velocity(rows, 1e-9), nullptr);
}

}  // namespace
}  // namespace hapton
