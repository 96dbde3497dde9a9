#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// What a running io_node reports of its device: calibration, firmware, temperature, and of the rights that it was granted. RT: no.
Findings check_hub(const Machine& machine);

}  // namespace hapton::doctor
