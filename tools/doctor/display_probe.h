#pragma once

#include "tools/doctor/machine.h"

namespace hapton::doctor {

// Finds what OpenGL can do on the X display that DISPLAY names, by libX11 and libGL loaded at run time. Draws nothing. A faulty driver may
// crash the calling process, therefore see run_in_child.h; connection and libraries stay open until it ends. RT: no.
DisplayReply probe_display();

}  // namespace hapton::doctor
