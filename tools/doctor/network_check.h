#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Checks the ports of hub and VRPN: free, or the process that uses them. RT: no.
Findings check_ports(const Machine& machine);
// Checks the key file of this user: place, rights, size, owner. RT: no.
Findings check_keys(const Machine& machine);
// Checks whether other hosts can reach the hub's port, as far as configuration files of firewalls show. RT: no.
Findings check_firewall(const Machine& machine);

}  // namespace hapton::doctor
