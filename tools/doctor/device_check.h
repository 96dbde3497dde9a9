#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Known devices that are plugged in: ids, nodes, drivers, rights, udev rules, sleep. Opens none of them. RT: no.
Findings check_devices(const Machine& machine);

// Daemons that meddle with devices, or that devices need: ModemManager, spacenavd, Haply's service. RT: no.
Findings check_services(const Machine& machine);

}  // namespace hapton::doctor
