#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// CPUs: their number, frequency governor, those set apart, whether a hypervisor shares them out. RT: no.
Findings check_cpus(const Machine& machine);
// The kernel's clock source. RT: no.
Findings check_clock(const Machine& machine);
// Whether the kernel lets a real-time thread in while it works itself. RT: no.
Findings check_kernel(const Machine& machine);

}  // namespace hapton::doctor
