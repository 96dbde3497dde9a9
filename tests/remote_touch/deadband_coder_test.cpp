#include "remote_touch/deadband_coder.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/support/time_units.h"

namespace hapton {
namespace {

const Vec3 kX = Vec3::UnitX();

TEST(PredictedSignal, HoldsTheLastValueOrFollowsALineForAWhile) {
  PredictedSignal signal;
  EXPECT_FALSE(signal.predict(0));
  signal.update({kX}, 0);
  EXPECT_EQ(signal.predict(7 * kMs), kX);
  signal.update({3.0 * kX, 0.2 / kMs * kX}, 10 * kMs);
  EXPECT_NEAR((*signal.predict(15 * kMs) - 4.0 * kX).norm(), 0.0, 1e-12);
  const double longest_ms = 1e-6 * static_cast<double>(PredictedSignal::kLongestNs);
  EXPECT_NEAR((*signal.predict(1000 * kMs) - (3.0 + 0.2 * longest_ms) * kX).norm(), 0.0, 1e-12) << "the line ends at kLongestNs";
}

TEST(DeadbandCoder, NoticesAChangeOfWebersFraction) {
  DeadbandCoder coder(0.1, 0.5, Prediction::hold);
  EXPECT_TRUE(coder.note(2.0 * kX, 0)) << "the first";
  (void)coder.send();
  EXPECT_FALSE(coder.note(2.19 * kX, kMs));
  EXPECT_TRUE(coder.note(2.21 * kX, kMs));
  EXPECT_TRUE(coder.note(2.0 * kX + 0.21 * Vec3::UnitY(), kMs)) << "of direction too";
  EXPECT_TRUE(coder.note(Vec3::Zero(), 2 * kMs));
  EXPECT_EQ(coder.send().value, Vec3::Zero());
  EXPECT_FALSE(coder.note(0.049 * kX, kMs)) << "a value below 0.5 counts as 0.5: the deadband is 0.05";
  EXPECT_TRUE(coder.note(0.051 * kX, kMs));
}

TEST(DeadbandCoder, WithFractionZeroEachValueIsSent) {
  DeadbandCoder coder(0.0, 0.5, Prediction::hold);
  (void)coder.note(kX, 0);
  (void)coder.send();
  EXPECT_TRUE(coder.note(kX, kMs));
}

// The slope is taken over the last ten values, or over all of them if there are fewer.
TEST(DeadbandCoder, TheSlopeIsThatOfTheLastTenValues) {
  for (const auto& [count, slope_per_ms] : {std::pair{1, 0.0}, {2, 1.0}, {5, 4.0}, {9, 8.0}, {10, 9.0}, {11, 11.0}, {25, 39.0}}) {
    DeadbandCoder linear(0.1, 0.1, Prediction::linear);
    DeadbandCoder hold(0.1, 0.1, Prediction::hold);
    for (int i = 0; i < count; ++i) {
      (void)linear.note(static_cast<double>(i * i) * kX, i * kMs);
      (void)hold.note(static_cast<double>(i * i) * kX, i * kMs);
    }
    const SignalUpdate update = linear.send();
    EXPECT_EQ(update.value.x(), static_cast<double>((count - 1) * (count - 1)));
    EXPECT_NEAR(update.per_ns.x() * kMs, slope_per_ms, 1e-9) << count;
    EXPECT_EQ(hold.send().per_ns, Vec3(Vec3::Zero()));
  }
  DeadbandCoder at_once(0.1, 0.1, Prediction::linear);
  (void)at_once.note(kX, 7);
  (void)at_once.note(2.0 * kX, 7);
  EXPECT_EQ(at_once.send().per_ns, Vec3(Vec3::Zero())) << "without time between them";
}

// With `hold` a ramp needs an update for each tenth of its value; with `linear` it needs none once its slope is known.
TEST(DeadbandCoder, PredictionSavesUpdatesOfALine) {
  const auto updates_of = [](Prediction prediction) {
    DeadbandCoder coder(0.1, 0.1, prediction);
    int updates = 0;
    for (int i = 0; i < 50; ++i) {
      if (!coder.note((1.0 + 0.02 * i) * kX, i * kMs)) continue;
      (void)coder.send();
      ++updates;
    }
    return updates;
  };
  EXPECT_GE(updates_of(Prediction::hold), 6);
  EXPECT_EQ(updates_of(Prediction::linear), 2) << "at the first update the slope is not known yet";
}

}  // namespace
}  // namespace hapton
