#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Checks whether vision_node finds a display here, what its renderer is, and whether it supports quad-buffer stereo. RT: no.
Findings check_display(const Machine& machine);

// Examines the display in a child process, for Machine::Queries::display. RT: no. Pre: this process has no other threads.
DisplayReply try_display();

}  // namespace hapton::doctor
