#pragma once

#include "tools/doctor/machine.h"

namespace hapton::doctor {

// The OpenGL abilities of the X display of DISPLAY, through libX11 and libGL loaded at run time. Draws nothing. It runs in the caller's
// process, which a faulty driver may crash: see run_in_child.h. RT: no.
DisplayReply probe_display();

}  // namespace hapton::doctor
