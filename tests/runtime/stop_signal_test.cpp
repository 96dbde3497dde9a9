#include "runtime/stop_signal.h"

#include <gtest/gtest.h>

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

TEST(StopSignalTest, TheProgramMayRequestItself) {
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
