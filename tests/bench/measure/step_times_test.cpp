#include "bench/measure/step_times.h"

#include <gtest/gtest.h>

#include <numeric>

namespace hapton {
namespace {

TEST(TimeSpread, IsEmptyOfNothing) {
  const TimeSpread spread = spread_of_times({});
  EXPECT_EQ(spread.count, 0U);
  EXPECT_EQ(spread.worst_ns, 0.0);
}

TEST(TimeSpread, TakesQuantilesByNearestRankInAnyOrder) {
  std::vector<double> ns(1000);
  std::iota(ns.rbegin(), ns.rend(), 1.0);
  const TimeSpread spread = spread_of_times(ns);
  EXPECT_EQ(spread.count, 1000U);
  EXPECT_EQ(spread.p50_ns, 500.0);
  EXPECT_EQ(spread.p90_ns, 900.0);
  EXPECT_EQ(spread.p99_ns, 990.0);
  EXPECT_EQ(spread.p99_9_ns, 999.0);
  EXPECT_EQ(spread.worst_ns, 1000.0);
}

TEST(TimeSpread, OfOneStepIsThatStep) {
  const TimeSpread spread = spread_of_times({7.0});
  EXPECT_EQ(spread.p50_ns, 7.0);
  EXPECT_EQ(spread.p99_ns, 7.0);
  EXPECT_EQ(spread.worst_ns, 7.0);
}

// Noise slows different steps in each repetition; the worst step is the slowest that was slow every time.
TEST(LeastTimes, WorstStepIsTheMaximumOfTheMinima) {
  LeastTimes least(3);
  const double repetitions[3][3] = {{10, 900, 30}, {800, 20, 35}, {11, 21, 700}};
  for (const auto& repetition : repetitions) {
    for (std::size_t i = 0; i < 3; ++i) least.add(i, repetition[i]);
  }
  EXPECT_EQ(least.ns(), (std::vector<double>{10, 20, 30}));
  EXPECT_EQ(spread_of_times(least.ns()).worst_ns, 30.0);
  EXPECT_EQ(least.only({1, 0, 1}), (std::vector<double>{10, 30}));
}

TEST(TimeSteps, RunsEveryStepInEveryRepetition) {
  const Stopwatch watch = Stopwatch::calibrate();
  std::vector<int> before(5, 0);
  std::vector<int> steps(5, 0);
  const TimedSteps timed = time_steps(
      watch, {.repetitions = 3, .seconds = 1e9}, 5, [&](std::size_t i) { ++before[i]; }, [&](std::size_t i) { ++steps[i]; },
      [](std::size_t) {});
  EXPECT_EQ(timed.repetitions, 3);
  // Five passes: three repetitions, and two passes for the mean.
  EXPECT_EQ(before, std::vector<int>(5, 5));
  EXPECT_EQ(steps, std::vector<int>(5, 5));
  EXPECT_GT(timed.mean_ns, 0.0);
  for (const double ns : timed.least.ns()) EXPECT_GE(ns, 0.0);
}

TEST(TimeSteps, BeginsNoSecondRepetitionWithoutTime) {
  const Stopwatch watch = Stopwatch::calibrate();
  int steps = 0;
  const TimedSteps timed = time_steps(
      watch, {.repetitions = 100, .seconds = 0.0}, 4, [](std::size_t) {}, [&](std::size_t) { ++steps; }, [](std::size_t) {});
  EXPECT_EQ(timed.repetitions, 1);
  EXPECT_EQ(steps, 4);
}

TEST(CpuPin, GivesTheOtherCpusBack) {
  cpu_set_t before;
  cpu_set_t after;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  {
    const CpuPin pin;
    cpu_set_t during;
    ASSERT_EQ(sched_getaffinity(0, sizeof during, &during), 0);
    if (pin.cpu() >= 0) {
      EXPECT_EQ(CPU_COUNT(&during), 1);
      EXPECT_TRUE(CPU_ISSET(static_cast<std::size_t>(pin.cpu()), &during));
    }
  }
  ASSERT_EQ(sched_getaffinity(0, sizeof after, &after), 0);
  EXPECT_TRUE(CPU_EQUAL(&before, &after));
}

}  // namespace
}  // namespace hapton
