#pragma once

#include "core/base/result.h"
#include "scene/scene_file.h"

namespace hapton {

// Checks whether objects that move or deform can be combined with the rest of the scene. has_tool: the stylus holds a rigid tool. RT: no.
// Error, one line: a rigid tool does not support what deforms, and movable objects support neither.
Result<void> check_motion(const Scene& scene, bool has_tool);

// The same for objects that can be carved: a rigid tool would touch their original shape, and picking up another object builds the scene
// again, without the carves. RT: no. Error, one line: a rigid tool and movable objects do not support them.
Result<void> check_sculpt(const Scene& scene, bool has_tool);

}  // namespace hapton
