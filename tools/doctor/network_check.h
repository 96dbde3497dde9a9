#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Each check reads the machine and changes nothing; a finding has the command that fixes it. RT: no. Threads: one.

// Whether the ports of the hub and of VRPN are free, or used by io_node itself; otherwise the process that uses them.
Findings check_ports(const Machine& machine);
// The key file of this user, and that of the services (/etc/hapton/key) if there is one or an enabled service needs it: place, owner,
// rights, size.
Findings check_keys(const Machine& machine);
// Whether other hosts can reach the hub's port, as far as the configuration files of ufw, firewalld or nftables show.
Findings check_firewall(const Machine& machine);

}  // namespace hapton::doctor
