#pragma once

#include "core/base/result.h"
#include "scene/scene_file.h"

namespace hapton {

// Whether the objects of a scene that move by keyframes, or deform, can be felt beside the rest. has_tool: the stylus holds a rigid tool.
// RT: no. Error: one line: with a rigid tool, and beside movable objects, they cannot yet.
Result<void> check_motion(const Scene& scene, bool has_tool);

// The same for objects that can be carved: a rigid tool would touch them as they were, and to pick up another object builds the scene
// again. RT: no. Error: one line: with a rigid tool, and beside movable objects, they cannot yet.
Result<void> check_sculpt(const Scene& scene, bool has_tool);

}  // namespace hapton
