// Millions of cycles of hostile commands, device motions and clocks, in which the governor breaks none of its limits.
#include "tools/governor/governor_stress.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace hapton {
namespace {

constexpr std::uint64_t kStressSeed = 20261120;

std::string describe(const GovernorStressCount& count, std::size_t breach) {
  return std::string(to_string(static_cast<GovernorBreach>(breach))) + ": " + std::to_string(count.breaches[breach]) +
         " times, first in program " + std::to_string(count.findings[breach].program) + ", turn " +
         std::to_string(count.findings[breach].turn);
}

TEST(GovernorStress, HoldsAgainstHostilePrograms) {
  const GovernorStress stress(kStressSeed);
  GovernorStressCount count;
  for (std::uint64_t program = 0; count.turns < 3'000'000; ++program) GovernorStress::run(stress.program_seed(program), count);
  for (std::size_t breach = 0; breach < count.breaches.size(); ++breach) EXPECT_EQ(count.breaches[breach], 0U) << describe(count, breach);

  // Every stage, every latched fault and every kind of recovery occurs many times.
  const GovernorCounters& g = count.governors;
  EXPECT_GT(static_cast<double>(count.turns_with_force), 0.25 * static_cast<double>(count.turns));
  for (const std::uint64_t stage :
       {g.accepted, g.not_finite, g.rejected_old, g.rejected_future, g.command_timeouts, g.clamped, g.rate_limited, g.bad_samples,
        g.workspace_limited, g.speed_limited, g.damped, g.thermal_limited, g.releases, g.latched, g.resets, g.resets_rejected}) {
    EXPECT_GT(stage, 1000U);
  }
  for (int fault = 1; fault < kSafetyFaults; ++fault) EXPECT_GT(g.faults[static_cast<std::size_t>(fault)], 3U) << fault;

  // A check that comes near no limit has tested nothing.
  EXPECT_GT(count.worst.force, 0.999);
  EXPECT_GT(count.worst.torque, 0.999);
  EXPECT_GT(count.worst.force_slew, 0.999);
  EXPECT_GT(count.worst.torque_slew, 0.999);
  EXPECT_GT(count.worst.heat, 0.95);
  EXPECT_GT(count.worst.energy, 0.5);
  EXPECT_GT(count.worst.release_ms, 10.0);
}

TEST(GovernorStress, AProgramIsTheSameAgain) {
  const std::uint64_t seed = GovernorStress(3).program_seed(17);
  GovernorStressCount first;
  GovernorStressCount second;
  GovernorStress::run(seed, first);
  GovernorStress::run(seed, second);
  EXPECT_EQ(first.turns, second.turns);
  EXPECT_EQ(first.turns_with_force, second.turns_with_force);
  EXPECT_EQ(first.worst.energy, second.worst.energy);
  EXPECT_NE(GovernorStress(3).program_seed(18), seed);
  EXPECT_NE(GovernorStress(4).program_seed(17), seed);
}

TEST(GovernorStress, SumsKeepTheFirstFindingAndTheWorst) {
  GovernorStressCount sum;
  GovernorStressCount part;
  part.turns = 5;
  part.breaches[1] = 2;
  part.findings[1] = {42, 7};
  part.worst.heat = 0.5;
  sum.add(part);
  part.findings[1] = {43, 8};
  part.worst.heat = 0.4;
  sum.add(part);
  EXPECT_EQ(sum.turns, 10U);
  EXPECT_EQ(sum.total_breaches(), 4U);
  EXPECT_EQ(sum.findings[1].program, 42U);
  EXPECT_EQ(sum.worst.heat, 0.5);
}

TEST(GovernorStress, UsesNoHeap) {
  if (!AllocationGuard::is_available()) GTEST_SKIP() << "heap use cannot be counted in this build";
  GovernorStressCount count;
  AllocationGuard guard;
  GovernorStress::run(GovernorStress(1).program_seed(1), count);
  EXPECT_EQ(guard.count(), 0U);
}

// Each kind of force has about an eleventh of the phases. Forces that are not numbers have fewer, because the fault that follows latches
// and hides everything else: two in three of their phases have an active force (Force::active) in their place.
TEST(GovernorStress, ForcesThatAreNoNumbersAreRare) {
  constexpr double kTurns = 200'000.0;
  int without_command = 0;
  int not_finite = 0;
  int huge = 0;
  int tiny = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    HostileProgram program(seed);
    for (int turn = 0; turn < 1000; ++turn) {
      const HostileStep& step = program.turn({});
      if (!step.command) {
        ++without_command;
        continue;
      }
      const Vec3& force_n = step.command->wrench.force_n;
      const double size = force_n.allFinite() ? force_n.stableNorm() : 0.0;
      not_finite += force_n.allFinite() ? 0 : 1;
      huge += size > 1e200 ? 1 : 0;
      tiny += size > 0.0 && size < 1e-300 ? 1 : 0;
    }
  }
  EXPECT_NEAR(without_command / kTurns, 0.145, 0.03) << "and one in twenty of the others";
  EXPECT_NEAR(not_finite / kTurns, 0.007, 0.003);
  EXPECT_NEAR(huge / kTurns, 0.095, 0.02);
  EXPECT_NEAR(tiny / kTurns, 0.09, 0.02);
}

// The turns of a program in which there is force or torque.
std::vector<int> turns_with_output(std::uint64_t seed) {
  HostileProgram program(seed);
  SafetyGovernor governor(program.device());
  governor.require_button(program.button());
  std::vector<int> turns;
  Wrench out;
  for (int turn = 0; turn < program.turns(); ++turn) {
    const HostileStep& step = program.turn(out);
    if (step.tighter_limits) governor.tighten(*step.tighter_limits);
    if (step.resets_faults) (void)governor.reset_faults();
    if (step.temperature >= 0.0) governor.observe_temperature(step.temperature);
    governor.observe(step.sample, step.status);
    out = governor.step(step.command, step.now_ns);
    if (out.force_n.stableNorm() > 0.0 || out.torque_nm.stableNorm() > 0.0) turns.push_back(turn);
  }
  return turns;
}

// A stress run that loses what the evaluator found would say that every governor holds. The evaluator watches a governor that has accepted
// no command, so it objects to every output of the governor that runs.
TEST(GovernorStress, BreachesAreCountedWithTheProgramAndTheTurnOfTheFirst) {
  constexpr auto kTimeout = static_cast<std::size_t>(GovernorBreach::command_timeout);
  std::vector<std::uint64_t> seeds;
  for (std::uint64_t seed = 1; seeds.size() < 2; ++seed) {
    if (turns_with_output(seed).size() > 10) seeds.push_back(seed);
  }
  GovernorStressCount count;
  std::uint64_t expected_breaches = 0;
  for (const std::uint64_t seed : seeds) {
    HostileProgram program(seed);
    SafetyGovernor governor(program.device());
    const SafetyGovernor idle(program.device());
    GovernorEvaluator evaluator(program, idle);
    GovernorStress::run(seed, program, governor, evaluator, count);
    expected_breaches += turns_with_output(seed).size();
    EXPECT_EQ(count.breaches[kTimeout], expected_breaches) << seed;
    EXPECT_EQ(count.findings[kTimeout].program, seeds[0]) << "of the first one";
    EXPECT_EQ(count.findings[kTimeout].turn, turns_with_output(seeds[0]).front());
  }
  EXPECT_GE(count.total_breaches(), expected_breaches);
  EXPECT_EQ(count.programs, 2U);
}

}  // namespace
}  // namespace hapton
