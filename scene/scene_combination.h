#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "scene/scene_file.h"

namespace hapton {

// Checks whether the forces of everything in the scene can be computed together. has_tool: the stylus holds a rigid tool, of the scene or
// of a command line; it replaces the probe and leaves movable objects where they are. A rigid tool does not support what deforms, and would
// touch what can be carved in its original shape. A movable object becomes such a tool while it is held, so the same goes for a scene that
// has one. RT: no. Error: one line with path, the line in the file where it is known, the objects, and what to leave out.
Result<void> check_combination(const std::filesystem::path& path, const Scene& scene, bool has_tool);

}  // namespace hapton
