#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// What is wrong with the surface of an object, as it is touched: cracks that could be sealed are. probe_radius_m: 0 for a point. A ball is
// not bothered by openings that it does not fit through; a point by no thin wall. RT: set-up only.
CheckFindings check_surface(const SceneObject& object, double probe_radius_m);

}  // namespace hapton
