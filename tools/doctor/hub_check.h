#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Checks what an io_node that runs on this machine reports: calibration, firmware and temperature of its device, its rights. RT: no.
Findings check_hub(const Machine& machine);

}  // namespace hapton::doctor
