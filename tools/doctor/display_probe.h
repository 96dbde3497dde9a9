#pragma once

#include "tools/doctor/machine.h"

namespace hapton::doctor {

// What the X display of DISPLAY can do by OpenGL, asked through libX11 and libGL loaded at run time. Draws nothing.
// It runs in the caller's process, which a driver may take with it: run_in_child.h. RT: no.
DisplayAnswer probe_display();

}  // namespace hapton::doctor
