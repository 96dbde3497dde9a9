#include "link/budgeted_endpoint.h"

#include <gtest/gtest.h>

#include <array>

#include "tests/io_node/scripted_endpoint.h"
#include "tests/support/time_units.h"

namespace hapton {
namespace {

TEST(BudgetedEndpoint, HandsOutItsBudgetAndThenSleepsToTheDeadline) {
  SimulatedClock clock;
  ScriptedEndpoint inner(clock);
  BudgetedEndpoint budget(inner, clock);
  const std::byte junk[] = {std::byte{1}};
  for (int n = 0; n < 10; ++n) inner.arrive_raw(clock.now_ns(), {{9}, 9}, junk);
  std::array<std::byte, kMaxDatagramBytes> into = {};
  budget.renew(3);
  const std::int64_t begin_ns = clock.now_ns();
  for (int n = 0; n < 3; ++n) EXPECT_EQ(budget.receive(into, begin_ns + kMs).bytes, 1U);
  EXPECT_EQ(clock.now_ns(), begin_ns);
  EXPECT_EQ(budget.receive(into, begin_ns + kMs).bytes, 0U);
  EXPECT_EQ(clock.now_ns(), begin_ns + kMs) << "it must sleep, or the loop never blocks";
  EXPECT_EQ(budget.spent(), 1U);
  budget.renew(3);
  EXPECT_EQ(budget.receive(into, begin_ns + 2 * kMs).bytes, 1U);
}

TEST(BudgetedEndpoint, APassedDeadlineStillSleepsForAMoment) {
  SimulatedClock clock;
  ScriptedEndpoint inner(clock);
  BudgetedEndpoint budget(inner, clock);
  budget.renew(0);
  std::array<std::byte, kMaxDatagramBytes> into = {};
  const std::int64_t begin_ns = clock.now_ns();
  budget.receive(into, 0);
  EXPECT_EQ(clock.now_ns(), begin_ns + BudgetedEndpoint::kShortestSleepNs);
}

TEST(BudgetedEndpoint, WaitingWithoutDatagramsCostsNothing) {
  SimulatedClock clock;
  ScriptedEndpoint inner(clock);
  BudgetedEndpoint budget(inner, clock);
  budget.renew(1);
  std::array<std::byte, kMaxDatagramBytes> into = {};
  for (int n = 0; n < 5; ++n) EXPECT_EQ(budget.receive(into, clock.now_ns() + kMs).bytes, 0U);
  EXPECT_EQ(budget.spent(), 0U);
}

}  // namespace
}  // namespace hapton
