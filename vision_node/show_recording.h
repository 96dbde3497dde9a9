#pragma once

#include "runtime/clock.h"
#include "runtime/stop_signal.h"
#include "vision_node/vision_options.h"

namespace hapton {

// vision_node --session: opens the recording, its scene and the window, and runs until the window is closed or `stop` is requested. head:
// null if there is no head tracker. Returns the exit code; errors are logged, one line each. RT: no.
int show_recording(VisionOptions& options, HeadTracker* head, Clock& clock, const StopSignal& stop);

}  // namespace hapton
