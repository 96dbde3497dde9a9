#include "link/fault_schedule.h"

#include <gtest/gtest.h>

namespace hapton {
namespace {

FaultPhase phase(std::int64_t duration_ns) { return {.name = "p", .duration_ns = duration_ns, .to_hub = {}, .to_nodes = {}}; }

TEST(FaultScheduleTest, PhasesFollowEachOtherAndEnd) {
  const FaultSchedule schedule{.phases = {phase(10), phase(5)}, .repeat = false};
  EXPECT_EQ(schedule.find_phase(0), 0U);
  EXPECT_EQ(schedule.find_phase(9), 0U);
  EXPECT_EQ(schedule.find_phase(10), 1U);
  EXPECT_EQ(schedule.find_phase(14), 1U);
  EXPECT_EQ(schedule.find_phase(15), 2U);
  EXPECT_EQ(schedule.find_phase(1'000'000'000'000), 2U);
}

TEST(FaultScheduleTest, RepeatedTheyBeginAgain) {
  const FaultSchedule schedule{.phases = {phase(10), phase(5)}, .repeat = true};
  EXPECT_EQ(schedule.find_phase(15), 0U);
  EXPECT_EQ(schedule.find_phase(25), 1U);
  EXPECT_EQ(schedule.find_phase(15'000'000'000'012), 1U);
}

TEST(FaultScheduleTest, AnEndlessPhaseHoldsForEver) {
  const FaultSchedule schedule{.phases = {phase(10), phase(FaultPhase::kForever)}, .repeat = true};
  EXPECT_EQ(schedule.find_phase(9), 0U);
  EXPECT_EQ(schedule.find_phase(FaultPhase::kForever - 1), 1U);
  EXPECT_EQ(FaultSchedule().find_phase(3), 0U);
}

}  // namespace
}  // namespace hapton
