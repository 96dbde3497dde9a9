#pragma once

#include <sched.h>

namespace hapton {

// Keeps the calling thread on one CPU, the last of those it may use, until destroyed. Threads started meanwhile inherit the pin: start
// them before. RT: set-up only.
class CpuPin {
 public:
  CpuPin();
  ~CpuPin();
  CpuPin(const CpuPin&) = delete;
  CpuPin& operator=(const CpuPin&) = delete;

  int cpu() const { return cpu_; }  // -1: the system denied it

 private:
  cpu_set_t before_ = {};
  int cpu_ = -1;
};

// The system's load average over the last minute; negative when it cannot be read.
double read_load_average();

}  // namespace hapton
