#include "runtime/spin_trial.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

// Waits until the trial has spun `spins` times; returns the number of waits that did not spin meanwhile.
std::uint32_t run(SpinTrial& trial, std::uint32_t spins, bool arrived) {
  std::uint32_t others = 0;
  for (std::uint32_t n = 0; n < spins;) {
    if (!trial.may_spin()) {
      ++others;
      continue;
    }
    trial.note(arrived);
    ++n;
  }
  return others;
}

TEST(SpinTrial, SpinsAsLongAsDatagramsArriveMeanwhile) {
  SpinTrial trial;
  EXPECT_EQ(run(trial, 10 * SpinTrial::kWaits, true), 0U);
}

TEST(SpinTrial, HalfOfTheWaitsAreEnoughAndOneFewerIsNot) {
  for (const std::uint32_t arrivals : {SpinTrial::kWaits / 2, SpinTrial::kWaits / 2 - 1}) {
    SpinTrial trial;
    for (std::uint32_t n = 0; n < SpinTrial::kWaits; ++n) trial.note(n < arrivals);
    EXPECT_EQ(trial.may_spin(), arrivals == SpinTrial::kWaits / 2);
  }
}

TEST(SpinTrial, EachFailureDoublesThePauseUpToTheLongest) {
  SpinTrial trial;
  run(trial, SpinTrial::kWaits, false);
  std::uint32_t pause = SpinTrial::kFirstPause;
  for (int n = 0; n < 12; ++n) {
    EXPECT_EQ(run(trial, SpinTrial::kWaits, false), pause);
    pause = std::min(2 * pause, SpinTrial::kLongestPause);
  }
  EXPECT_EQ(pause, SpinTrial::kLongestPause);
}

TEST(SpinTrial, ASuccessBringsTheFirstPauseBack) {
  SpinTrial trial;
  for (int n = 0; n < 3; ++n) run(trial, SpinTrial::kWaits, false);
  run(trial, SpinTrial::kWaits, true);
  EXPECT_EQ(run(trial, SpinTrial::kWaits, false), 0U);
  EXPECT_EQ(run(trial, 1, false), SpinTrial::kFirstPause);
}

}  // namespace
}  // namespace hapton
