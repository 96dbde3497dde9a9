#pragma once

#include <cstddef>
#include <vector>

#include "core/force/touch_scene.h"

namespace hapton {

// Points of what can be touched, spread over it: up to `most`, the same for the same scene. Where a scene has more than one object, each
// has its share by its area. Frame S, m. RT: set-up only.
std::vector<Vec3> find_surface_points(const TouchScene& scene, std::size_t most);

}  // namespace hapton
