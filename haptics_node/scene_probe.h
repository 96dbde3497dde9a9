#pragma once

#include "core/base/result.h"
#include "haptics_node/haptics_options.h"

namespace hapton {

// Takes radius, method and shading from the [[probe]] of the scene file that --probe names, or from the first one, unless flags give them;
// a line of the log says so. A scene file without probes, and a mesh file, change nothing. RT: no. Error: one line: there is no such
// probe. What is wrong with the file itself is left to load_scene.
Result<void> take_scene_probe(HapticsOptions& options);

}  // namespace hapton
