#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// What a rigid tool, or an object that the stylus picks up, meets in the scene: surfaces of which it feels only the shape, and movable
// objects that overlap or touch another one where they lie. Nothing where the scene has neither a tool nor movable objects. RT: no; builds
// each movable object and the others for contact.
CheckFindings check_tool(const Scene& scene);

}  // namespace hapton
