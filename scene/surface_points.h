#pragma once

#include <cstddef>
#include <vector>

#include "core/force/touch_scene.h"

namespace hapton {

// Up to `most` points on the surfaces that can be touched, spread evenly over all objects. Deterministic: the same for the same scene.
// Frame S, metres. RT: set-up only.
std::vector<Vec3> find_surface_points(const TouchScene& scene, std::size_t most);

}  // namespace hapton
