#include "link/fault_schedule.h"

namespace hapton {

std::size_t FaultSchedule::find_phase(std::int64_t elapsed_ns) const noexcept {
  std::int64_t total_ns = 0;
  bool is_endless = false;
  for (const FaultPhase& phase : phases) {
    is_endless = is_endless || phase.duration_ns > FaultPhase::kForever - total_ns;
    total_ns = is_endless ? FaultPhase::kForever : total_ns + phase.duration_ns;
  }
  if (repeat && !is_endless && total_ns > 0) elapsed_ns %= total_ns;
  std::size_t phase = 0;
  while (phase < phases.size() && elapsed_ns >= phases[phase].duration_ns) elapsed_ns -= phases[phase++].duration_ns;
  return phase;
}

}  // namespace hapton
