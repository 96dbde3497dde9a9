#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "scene/scene_file.h"

namespace hapton {

// Checks whether the forces of everything in the scene can be computed together. has_tool: the stylus holds a rigid tool, from the scene or
// a command line; it replaces the probe, and movable objects stay where they are. A rigid tool does not support objects that deform, and
// would touch carved objects in their original shape. A movable object is such a tool while it is held, so the same applies to a scene with
// one. RT: no. Error: one line with path, the line in the file if it is known, the objects, and what to leave out.
Result<void> check_combination(const std::filesystem::path& path, const Scene& scene, bool has_tool);

}  // namespace hapton
