#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// All checks below read the machine and change nothing; a warning or problem has the command that fixes it. RT: no. Threads: one.

// Checks whether the ports of the hub and of VRPN are free or used by io_node itself; otherwise names the process that uses them.
Findings check_ports(const Machine& machine);
// Checks the given or else the user's own key file, and that of the services (/etc/hapton/key) if it exists or an enabled service needs it:
// place, owner (of the former), rights, size.
Findings check_keys(const Machine& machine);
// Checks whether other hosts can reach the hub's port, judged only by the configuration files of ufw, firewalld and nftables.
Findings check_firewall(const Machine& machine);

}  // namespace hapton::doctor
