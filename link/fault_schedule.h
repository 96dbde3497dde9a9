#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "link/fault_injector.h"

namespace hapton {

// A period in which the network has certain faults.
struct FaultPhase {
  static constexpr std::int64_t kForever = std::numeric_limits<std::int64_t>::max();

  std::string name;
  std::int64_t duration_ns = kForever;
  LinkFaults to_hub;
  LinkFaults to_nodes;
};

// Phases one after the other. After the last one there are no faults, or, with `repeat`, the phases begin again.
struct FaultSchedule {
  std::vector<FaultPhase> phases;
  bool repeat = false;

  // The index of the phase at that time; phases.size() after the last. Pre: elapsed_ns >= 0, durations above 0.
  std::size_t find_phase(std::int64_t elapsed_ns) const noexcept;
};

}  // namespace hapton
