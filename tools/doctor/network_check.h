#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// The hub's port and VRPN's: free, or who has them. RT: no.
Findings check_ports(const Machine& machine);
// The key that nodes share: rights, size, owner, where. RT: no.
Findings check_keys(const Machine& machine);
// Whether other hosts reach the hub's port, as far as configuration files show. RT: no.
Findings check_firewall(const Machine& machine);

}  // namespace hapton::doctor
