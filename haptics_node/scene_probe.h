#pragma once

#include "core/base/result.h"
#include "haptics_node/haptics_options.h"

namespace hapton {

// Takes radius, method and shading from the [[probe]] of the scene file that --probe names, or from the first one, unless flags give them,
// and logs this in a line. Without --probe, a scene file without probes and a mesh file change nothing. Error: one line: there is no such
// probe; a mesh file has none. Faults of the scene file itself are not an error here: load_scene reports them. RT: no.
Result<void> take_scene_probe(HapticsOptions& options);

}  // namespace hapton
