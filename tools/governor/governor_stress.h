#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "tools/governor/governor_evaluator.h"

namespace hapton {

// Where something went wrong first, to be found again.
struct GovernorFinding {
  std::uint64_t program = 0;  // its seed
  int turn = 0;
};

struct GovernorStressCount {
  std::uint64_t turns = 0;
  std::uint64_t programs = 0;
  std::uint64_t turns_with_force = 0;  // turns with a force on the motors
  std::array<std::uint64_t, static_cast<std::size_t>(GovernorBreach::count)> breaches = {};
  std::array<GovernorFinding, static_cast<std::size_t>(GovernorBreach::count)> findings = {};  // of each breach there is
  GovernorCounters governors;  // counts of the stages, to show that each has been reached
  GovernorWorst worst;

  std::uint64_t total_breaches() const noexcept;
  void add(const GovernorStressCount& other) noexcept;
};

// Runs fresh governors with hostile programs and evaluates every turn. Program n of a seed depends only on these two. RT: no heap. Threads:
// one each.
class GovernorStress {
 public:
  explicit GovernorStress(std::uint64_t seed) noexcept : seed_(seed) {}

  // What names a program.
  std::uint64_t program_seed(std::uint64_t program) const noexcept;
  // Runs one to its end.
  static void run(std::uint64_t program_seed, GovernorStressCount& count) noexcept;

 private:
  std::uint64_t seed_;
};

}  // namespace hapton
