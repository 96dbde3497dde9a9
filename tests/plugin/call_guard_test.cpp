#include "plugin/call_guard.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

using ::testing::HasSubstr;

struct CallGuardTest : testing::Test {
  SimulatedClock clock;
  CallGuard guard{clock, CallBudget::kDefaultNs, 2.0, 0.1};
  int calls = 0;

  Vec3 step_with(const Vec3& force_n, const Vec3& torque_nm = Vec3::Zero()) {
    return guard
        .step(1e-3,
              [&](PluginForce& output) {
                ++calls;
                output = {force_n, torque_nm};
              })
        .force_n;
  }
};

TEST_F(CallGuardTest, AGoodForcePasses) {
  EXPECT_EQ(step_with({0.0, 2.0, 0.0}), Vec3(0.0, 2.0, 0.0));
  EXPECT_FALSE(guard.cut_off());
  EXPECT_EQ(guard.most_n(), 2.0);
  EXPECT_EQ(guard.times().count(), 1U);
}

// The force goes from the last good one to zero, in steps of a hundredth of it.
TEST_F(CallGuardTest, AfterNonsenseTheLastGoodForceFadesAndNothingIsCalledAgain) {
  for (const Vec3& nonsense : {Vec3(std::nan(""), 0, 0), Vec3(0, std::numeric_limits<double>::infinity(), 0), Vec3(0, 0, 1e9),
                               Vec3(std::numeric_limits<double>::max(), 0, 0), Vec3(2.1, 0, 0)}) {
    CallGuard fresh(clock, CallBudget::kDefaultNs, 2.0, 0.1);
    int called = 0;
    const auto step = [&](const Vec3& force_n) {
      return fresh.step(1e-3, [&](PluginForce& output) {
        ++called;
        output.force_n = force_n;
      });
    };
    double last_n = step({1.5, 0, 0}).force_n.norm();
    for (int n = 0; n < 200; ++n) {
      const double now_n = step(nonsense).force_n.norm();
      EXPECT_LE(now_n, last_n);
      EXPECT_GE(now_n, last_n - 0.0151) << "no jump";
      last_n = now_n;
    }
    EXPECT_EQ(called, 2);
    EXPECT_EQ(last_n, 0.0);
    EXPECT_TRUE(fresh.cut_off());
  }
}

TEST_F(CallGuardTest, TorqueHasItsOwnLimit) {
  step_with({1, 0, 0}, {0.1, 0, 0});
  EXPECT_FALSE(guard.cut_off());
  step_with({1, 0, 0}, {0.2, 0, 0});
  EXPECT_THAT(describe(guard.cut_off()), HasSubstr("0.2 Nm, its limit is 0.1 Nm"));
}

TEST_F(CallGuardTest, ATorqueThatIsNotFiniteIsNonsense) {
  step_with({1, 0, 0}, {0, std::nan(""), 0});
  EXPECT_THAT(describe(guard.cut_off()), HasSubstr("not finite"));
}

TEST_F(CallGuardTest, AnExceptionIsCaughtAndNamed) {
  step_with({1, 0, 0});
  const PluginForce after = guard.step(1e-3, [](PluginForce&) { throw std::runtime_error("no"); });
  EXPECT_NEAR(after.force_n.x(), 0.99, 1e-12);
  EXPECT_EQ(describe(guard.cut_off()), "it threw a C++ exception");
}

TEST_F(CallGuardTest, OverrunsCutOffWithTheLastGoodForce) {
  double last_n = 0.0;
  int steps = 0;
  for (; steps < 100 && !guard.cut_off(); ++steps) {
    last_n = guard
                 .step(1e-3,
                       [&](PluginForce& output) {
                         output.force_n = Vec3(1, 0, 0);
                         clock.advance_ns(CallBudget::kDefaultNs + 1);
                       })
                 .force_n.norm();
  }
  EXPECT_EQ(steps, 10);
  EXPECT_NEAR(last_n, 0.99, 1e-12);
  EXPECT_THAT(describe(guard.cut_off()), HasSubstr("its budget is 0.1 ms"));
}

TEST_F(CallGuardTest, ANewSessionFeelsNothingOfTheFade) {
  step_with({1, 0, 0});
  step_with({9, 0, 0});
  guard.forget();
  EXPECT_EQ(step_with({1, 0, 0}), Vec3(0, 0, 0));
  EXPECT_TRUE(guard.cut_off()) << "for good";
}

TEST_F(CallGuardTest, TheReportHasTheTimesOfTheCalls) {
  EXPECT_EQ(describe_calls(guard), "0 calls, maximum 0.000 N\n");
  for (int n = 0; n < 100; ++n) {
    guard.step(1e-3, [&](PluginForce& output) {
      output.force_n = Vec3(0.0, n == 7 ? -1.25 : 0.5, 0.0);
      clock.advance_ns(n < 60 ? 40 : n < 99 ? 80 : 127);
    });
  }
  EXPECT_EQ(describe_calls(guard), "100 calls, maximum 1.250 N; p50 0.04 us, p99 0.08, worst 0.13\n");
}

TEST_F(CallGuardTest, TheFadeTakesATenthOfASecondHoweverItIsCut) {
  for (const double dt_s : {1e-3, 2e-3, 0.025}) {
    CallGuard cut(clock, CallBudget::kDefaultNs, 2.0, 0.1);
    cut.step(dt_s, [](PluginForce& output) { output = {Vec3(1, 0, 0), Vec3(0, 0.1, 0)}; });
    double passed_s = 0.0;
    for (; passed_s < 0.0999 - dt_s; passed_s += dt_s) {
      const PluginForce faded = cut.step(dt_s, [](PluginForce&) { throw 1; });
      EXPECT_NEAR(faded.force_n.x(), 1.0 - (passed_s + dt_s) / CallGuard::kFadeS, 1e-9);
      EXPECT_NEAR(faded.torque_nm.y(), 0.1 * faded.force_n.x(), 1e-12);
    }
    cut.step(dt_s, [](PluginForce&) {});
    EXPECT_EQ(cut.step(dt_s, [](PluginForce&) {}).force_n, Vec3(0, 0, 0));
  }
}

TEST_F(CallGuardTest, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "allocations cannot be counted in this build";
  step_with({1, 0, 0});
  const AllocationGuard heap;
  for (int n = 0; n < 1000; ++n) step_with({n == 500 ? 1e9 : 1.0, 0, 0});
  EXPECT_EQ(heap.count(), 0U);
}

}  // namespace
}  // namespace hapton
