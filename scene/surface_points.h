#pragma once

#include <cstddef>
#include <vector>

#include "core/force/touch_scene.h"

namespace hapton {

// At most `max_points` points on the surfaces that can be touched, spread evenly over all objects as seen from the front (along z),
// or over the whole surface if the scene is seen edge-on from the front. The same scene gives the same points. Frame S, metres. RT: set-up
// only.
std::vector<Vec3> find_surface_points(const TouchScene& scene, std::size_t max_points);

}  // namespace hapton
