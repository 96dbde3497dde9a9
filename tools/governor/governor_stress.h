#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tools/governor/governor_evaluator.h"

namespace hapton {

// The first breach of one kind, with what reproduces it.
struct GovernorFinding {
  std::uint64_t program = 0;  // seed of the program, for GovernorStress::run
  int turn = 0;               // number of the turn in the program, from 0
};

// Totals over programs. A turn is one cycle: a device sample and a force command.
struct GovernorStressCount {
  std::uint64_t turns = 0;
  std::uint64_t programs = 0;
  std::uint64_t turns_with_force = 0;  // turns whose output force is not zero
  std::array<std::uint64_t, static_cast<std::size_t>(GovernorBreach::count)> breaches = {};
  std::array<GovernorFinding, static_cast<std::size_t>(GovernorBreach::count)> findings = {};  // valid where breaches is not 0
  GovernorCounters governors;  // sums of the governors' counters: they show that each stage was reached
  GovernorWorst worst;

  std::uint64_t total_breaches() const noexcept;
  void add(const GovernorStressCount& other) noexcept;
};

// Runs each hostile program (HostileProgram) with a new governor, and evaluates every turn. Program n depends only on n and the seed.
// RT: no heap. Threads: one for each object.
class GovernorStress {
 public:
  explicit GovernorStress(std::uint64_t seed) noexcept : seed_(seed) {}

  // The seed of program number `program`.
  std::uint64_t program_seed(std::uint64_t program) const noexcept;
  // Runs the program of this seed to its end and adds the results to count.
  static void run(std::uint64_t program_seed, GovernorStressCount& count) noexcept;
  // The same with this governor, watched by this evaluator. Pre: all three are new, and `program` was made from program_seed.
  static void run(std::uint64_t program_seed, HostileProgram& program, SafetyGovernor& governor, GovernorEvaluator& evaluator,
                  GovernorStressCount& count) noexcept;

 private:
  std::uint64_t seed_;
};

}  // namespace hapton
