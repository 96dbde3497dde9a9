#include "runtime/stop_signal.h"

#include <gtest/gtest.h>

#include <csignal>

namespace hapton {
namespace {

TEST(StopSignalTest, InterruptAndTerminateAskForAStop) {
  for (const int signal : {SIGINT, SIGTERM}) {
    StopSignal stop;
    EXPECT_FALSE(stop.stop_requested());
    std::raise(signal);
    EXPECT_TRUE(stop.stop_requested());
    EXPECT_FALSE(stop.take_report_request());
  }
}

TEST(StopSignalTest, UserSignalAsksForOneReport) {
  StopSignal stop;
  EXPECT_FALSE(stop.take_report_request());
  std::raise(SIGUSR1);
  EXPECT_TRUE(stop.take_report_request());
  EXPECT_FALSE(stop.take_report_request());
  EXPECT_FALSE(stop.stop_requested());
}

TEST(StopSignalTest, TheProgramMayAskForItself) {
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
