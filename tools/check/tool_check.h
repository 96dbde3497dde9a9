#pragma once

#include "core/base/result.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Flaws of the scene's rigid tool, and what it, or an object that the stylus picks up, meets in the scene: surfaces of which it feels only
// the shape, and movable objects that overlap or touch another one where they lie. Nothing where the scene has neither a tool nor movable
// objects. Error: haptics_node rejects the tool. RT: no; builds the tool, each movable object and the others for contact.
Result<CheckFindings> check_tool(const Scene& scene);

}  // namespace hapton
