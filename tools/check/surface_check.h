#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// What is wrong with the surface of an object, as it is touched: cracks that could be sealed are. probe_radius_m: 0 for a point. A ball is
// not bothered by openings that it does not fit through; a point by no thin wall. RT: set-up only.
CheckFindings check_surface(const SceneObject& object, double probe_radius_m);

// An object with a mass whose inertia is unknown (core/geometry/mass_properties.h). RT: set-up only.
CheckFindings check_inertia(const SceneObject& object);

}  // namespace hapton
