#pragma once

#include "tools/doctor/finding.h"
#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Checks the known devices that are plugged in: ids, nodes, drivers, rights, udev rules, autosuspend. Opens none of them. RT: no.
Findings check_devices(const Machine& machine);

// Checks the daemons that interfere with devices or that devices need: ModemManager, spacenavd, Haply's service. RT: no.
Findings check_services(const Machine& machine);

}  // namespace hapton::doctor
