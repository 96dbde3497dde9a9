#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Whether vision_node finds a display here, who draws, and whether it can do quad-buffer stereo. RT: no.
Findings check_display(const Machine& machine);

// Asks the display in a process of its own, for Machine::Questions. Pre: the caller has no other threads.
DisplayAnswer try_display();

}  // namespace hapton::doctor
