#include "runtime/stop_signal.h"

#include <gtest/gtest.h>

#include <array>
#include <csignal>

namespace hapton {
namespace {

TEST(StopSignalTest, InterruptAndTerminateRequestAStop) {
  for (const int signal : {SIGINT, SIGTERM}) {
    StopSignal stop;
    EXPECT_FALSE(stop.stop_requested());
    std::raise(signal);
    EXPECT_TRUE(stop.stop_requested());
    EXPECT_EQ(stop.report_requests(), 0U);
  }
}

TEST(StopSignalTest, EachUserSignalRequestsAReport) {
  StopSignal stop;
  EXPECT_EQ(stop.report_requests(), 0U);
  std::raise(SIGUSR1);
  EXPECT_EQ(stop.report_requests(), 1U);
  std::raise(SIGUSR1);
  EXPECT_EQ(stop.report_requests(), 2U);
  EXPECT_FALSE(stop.stop_requested());
}

constexpr std::array<int, 3> kSignals = {SIGINT, SIGTERM, SIGUSR1};
std::array<int, 3> handled_counts = {};  // of kSignals, while there was no StopSignal

// After a command that could be stopped, the handlers that a library set before it work again.
TEST(StopSignalTest, AnEarlierHandlerWorksAgainAfterwards) {
  std::array<struct sigaction, 3> before = {};
  struct sigaction own = {};
  own.sa_handler = [](int signal) {
    for (std::size_t i = 0; i < kSignals.size(); ++i) handled_counts[i] += signal == kSignals[i] ? 1 : 0;
  };
  for (std::size_t i = 0; i < kSignals.size(); ++i) ASSERT_EQ(sigaction(kSignals[i], &own, &before[i]), 0);
  handled_counts = {};
  {
    const StopSignal stop;
    for (const int signal : {SIGINT, SIGUSR1}) std::raise(signal);
    EXPECT_EQ(handled_counts, (std::array<int, 3>{0, 0, 0}));
  }
  for (const int signal : kSignals) std::raise(signal);
  EXPECT_EQ(handled_counts, (std::array<int, 3>{1, 1, 1}));
  for (std::size_t i = 0; i < kSignals.size(); ++i) ASSERT_EQ(sigaction(kSignals[i], &before[i], nullptr), 0);
}

TEST(StopSignalTest, ANewOneKnowsNothingOfTheLast) {
  {
    StopSignal stop;
    stop.request_stop();
    std::raise(SIGUSR1);
  }
  const StopSignal stop;
  EXPECT_FALSE(stop.stop_requested());
  EXPECT_EQ(stop.report_requests(), 0U);
}

TEST(StopSignalTest, TheProgramMayRequestAStopItself) {
  StopSignal stop;
  stop.request_stop();
  EXPECT_TRUE(stop.stop_requested());
}

TEST(StopSignalDeathTest, ASecondInterruptEndsTheProcess) {
  EXPECT_EXIT(
      {
        StopSignal stop;
        std::raise(SIGINT);
        std::raise(SIGINT);
      },
      testing::KilledBySignal(SIGINT), "");
}

}  // namespace
}  // namespace hapton
