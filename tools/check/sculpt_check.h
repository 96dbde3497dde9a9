#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Finds in an object that can be carved: walls so thin that its voxels may miss them, and a carving ball of less than three voxels in
// radius. A surface that is not closed, or too many voxels, are errors when the scene is read, and not checked here. RT: no.
CheckFindings check_sculpt(const SceneObject& object);

}  // namespace hapton
