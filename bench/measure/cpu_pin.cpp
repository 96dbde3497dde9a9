#include "bench/measure/cpu_pin.h"

#include <cstdlib>

namespace hapton {

CpuPin::CpuPin() {
  CPU_ZERO(&previous_mask_);
  if (sched_getaffinity(0, sizeof previous_mask_, &previous_mask_) != 0) return;
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0; --cpu) {
    if (!CPU_ISSET(static_cast<std::size_t>(cpu), &previous_mask_)) continue;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(cpu), &one);
    if (sched_setaffinity(0, sizeof one, &one) == 0) cpu_ = cpu;
    return;
  }
}

CpuPin::~CpuPin() {
  if (cpu_ >= 0) sched_setaffinity(0, sizeof previous_mask_, &previous_mask_);
}

double read_load_average() {
  double load = 0.0;
  return getloadavg(&load, 1) == 1 ? load : -1.0;
}

}  // namespace hapton
