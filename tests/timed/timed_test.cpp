// Most of these tests stop hapton_timed for a while: to hapton_timed that looks as if the machine stood still.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "tests/support/scratch_folder.h"
#include "tests/timed/stall_watch.h"

namespace hapton {
namespace {

struct Timed : testing::Test {
  ScratchFolder folder;
  const std::string runs = (folder.path() / "runs").string();

  // Runs a shell script and returns the exit code.
  int run(const std::string& script) {
    const auto file = folder.path() / "script";
    std::ofstream(file) << "echo run >> " << runs << "\n" << script << "\n";
    return WEXITSTATUS(std::system((std::string(HAPTON_TIMED) + " sh " + file.string() + " > " + runs + ".out").c_str()));
  }
  int count_runs() const {
    std::ifstream file(runs);
    int n = 0;
    for (std::string line; std::getline(file, line);) ++n;
    return n;
  }
  const std::string stall = "kill -STOP $PPID; sleep 0.2; kill -CONT $PPID; ";
};

TEST_F(Timed, WhatPassesIsRunOnce) {
  EXPECT_EQ(run(stall + "exit 0"), 0);
  EXPECT_EQ(count_runs(), 1);
}

TEST_F(Timed, AFailureOnAMachineThatStoodStillIsTriedAgain) {
  EXPECT_EQ(run(stall + "test $(wc -l < " + runs + ") -ge 3"), 0);
  EXPECT_EQ(count_runs(), 3);
}

TEST_F(Timed, WhatFailsInEachRunWhileTheMachineStandsStillIsSkipped) {
  EXPECT_EQ(run(stall + "exit 1"), 77);
  EXPECT_EQ(count_runs(), 5);
}

// This machine may stand still meanwhile: then each repetition has a line that says for how long.
TEST_F(Timed, AFailureWithoutAStallIsNotRepeated) {
  const int code = run("exit 3");
  EXPECT_TRUE(code == 3 || (code == 77 && count_runs() == 5)) << code;
  std::ifstream output(runs + ".out");
  int stalls = 0;
  for (std::string line; std::getline(output, line);) {
    int number = 0;
    double stall_ms = 0.0;
    constexpr const char* kLine = "run %d failed (exit code 3), and this machine stood still for up to %lf ms meanwhile";
    if (std::sscanf(line.c_str(), kLine, &number, &stall_ms) != 2) continue;
    EXPECT_EQ(number, ++stalls);
    EXPECT_GE(stall_ms, 0.5e-6 * static_cast<double>(StallWatch::kForceLifeNs) - 0.05) << "less than is noticed, and rounding";
  }
  EXPECT_GE(count_runs(), 1);
  EXPECT_LE(count_runs(), stalls + 1);
}

TEST_F(Timed, ACommandThatIsNotThere) {
  const int code = WEXITSTATUS(std::system((std::string(HAPTON_TIMED) + " /no/such/command 2> " + runs + ".err").c_str()));
  EXPECT_TRUE(code == 127 || code == 77) << code;
}

}  // namespace
}  // namespace hapton
