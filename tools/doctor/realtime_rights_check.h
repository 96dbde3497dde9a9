#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// The rights that the servo loop needs: priority, locked memory, and its real-time share. RT: no.
Findings check_rights(const Machine& machine);

// How soon CPUs wake from idle, for this user. RT: no.
Findings check_sleep(const Machine& machine);

// The line that gives this user the rights of real time, or says that the session is older than they are. RT: no.
std::string line_that_grants_realtime(const Machine& machine);

}  // namespace hapton::doctor
