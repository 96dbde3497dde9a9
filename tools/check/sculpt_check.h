#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// An object that can be carved: walls that its voxels may lose, and a ball of few voxels. A surface that is not closed, and too many
// voxels, are errors when the scene is read. RT: no.
CheckFindings check_sculpt(const SceneObject& object);

}  // namespace hapton
