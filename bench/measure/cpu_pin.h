#pragma once

#include <sched.h>

namespace hapton {

// Keeps the calling thread on one CPU, the last of those that it may use, until this object is destroyed. A thread started meanwhile
// inherits the pin: start other threads earlier. RT: set-up only.
class CpuPin {
 public:
  CpuPin();
  ~CpuPin();
  CpuPin(const CpuPin&) = delete;
  CpuPin& operator=(const CpuPin&) = delete;

  int cpu() const { return cpu_; }  // number of the CPU; -1: the system refused to pin the thread

 private:
  cpu_set_t previous_mask_ = {};
  int cpu_ = -1;
};

// The system's load average over the last minute; negative if it cannot be read.
double read_load_average();

}  // namespace hapton
