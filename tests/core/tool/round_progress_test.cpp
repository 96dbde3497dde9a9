#include "core/tool/round_progress.h"

#include <gtest/gtest.h>

#include <array>

namespace hapton {
namespace {

constexpr double kLeastGain = 0.125;

Placement placement_at(double x) { return {Vec3(x, 0.0, 0.0), Quat::Identity()}; }

// The number of rounds until progress stalls; -1: never. The rounds begin at `distances` in turn; the last `repeat_count` of them repeat.
template <std::size_t kCount>
int rounds_until_stalled(const std::array<double, kCount>& distances, std::size_t repeat_count) {
  RoundProgress progress(kLeastGain);
  progress.restart();
  for (std::size_t n = 0; n < 100; ++n) {
    const double d = distances[n < kCount ? n : kCount - repeat_count + (n - kCount) % repeat_count];
    if (progress.begin_round(placement_at(static_cast<double>(n)), d)) return static_cast<int>(n);
  }
  return -1;
}

TEST(RoundProgress, ACycleIsStalledAfterItsFirstRounds) {
  EXPECT_EQ(rounds_until_stalled(std::array{10.0, 8.0, 7.0}, 2), 2 + RoundProgress::kPatience);
  EXPECT_EQ(rounds_until_stalled(std::array{10.0, 8.0, 9.0, 7.0}, 3), 3 + RoundProgress::kPatience);
}

TEST(RoundProgress, EverShorterMotionsAreStalled) {
  RoundProgress progress(kLeastGain);
  progress.restart();
  int n = 0;
  double distance = 5.0;
  for (double gain = 1.0; n < 100 && !progress.begin_round(placement_at(distance), distance); ++n) distance -= gain *= 0.5;
  EXPECT_GT(n, RoundProgress::kPatience);
  EXPECT_LT(n, 12);
}

TEST(RoundProgress, SmallGainsAddUp) {
  RoundProgress progress(kLeastGain);
  progress.restart();
  double distance = 100.0;
  for (int n = 0; n < 100; ++n, distance -= 1.01 * kLeastGain / RoundProgress::kPatience) {
    ASSERT_FALSE(progress.begin_round(placement_at(distance), distance)) << n;
  }
}

TEST(RoundProgress, ARoundThatDoesNotMoveIsNotCounted) {
  RoundProgress progress(kLeastGain);
  progress.restart();
  for (int n = 0; n < 100; ++n) ASSERT_FALSE(progress.begin_round(placement_at(0.0), 1.0));
}

TEST(RoundProgress, TheBestIsTheNearest) {
  RoundProgress progress(kLeastGain);
  progress.restart();
  progress.begin_round(placement_at(1.0), 3.0);
  EXPECT_TRUE(progress.is_best());
  progress.begin_round(placement_at(2.0), 1.0);
  EXPECT_TRUE(progress.is_best());
  progress.begin_round(placement_at(3.0), 2.0);
  EXPECT_FALSE(progress.is_best());
  EXPECT_EQ(progress.best(), placement_at(2.0));
  progress.restart();
  progress.begin_round(placement_at(4.0), 9.0);
  EXPECT_TRUE(progress.is_best());
  EXPECT_EQ(progress.best(), placement_at(4.0));
}

}  // namespace
}  // namespace hapton
