#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Checks the CPUs: their number, which are isolated for real time, the frequency governor, whether there is a hypervisor. RT: no.
Findings check_cpus(const Machine& machine);
// Checks whether the kernel's clock source is fast. RT: no.
Findings check_clock(const Machine& machine);
// Checks whether a real-time thread can preempt the kernel's own work. RT: no.
Findings check_kernel(const Machine& machine);

}  // namespace hapton::doctor
