#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Finds flaws in the surface of an object as it is touched, which is after its cracks were sealed where possible. probe_radius_m: 0 for a
// point. For a ball, openings that it does not fit through do not count; for a point, thin walls do not count. RT: set-up only.
CheckFindings check_surface(const SceneObject& object, double probe_radius_m);

// Finds an object with a mass whose inertia is unknown, see core/geometry/mass_properties.h. RT: set-up only.
CheckFindings check_inertia(const SceneObject& object);

}  // namespace hapton
