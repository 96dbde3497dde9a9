#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Checks the rights that the servo loop needs: priority, locked memory, and its share of real time. RT: no.
Findings check_rights(const Machine& machine);

// Checks how fast CPUs wake from idle, and whether this user may keep them out of deep sleep. RT: no.
Findings check_sleep(const Machine& machine);

// The command that gives this user real-time rights; if the user has them since this session began: to log in again. RT: no.
std::string line_that_grants_realtime(const Machine& machine);

}  // namespace hapton::doctor
