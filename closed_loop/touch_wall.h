#pragma once

#include <memory>

#include "closed_loop/force_law.h"
#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// A plate of 200 x 200 mm at x = 0 that faces +x. RT: set-up only.
std::shared_ptr<const TriangleMesh> make_wall_mesh();

// The one-sided wall of WallLaw, made of that plate and touched by the proxy method that the haptics node runs. Error: that of make_method.
// RT: set-up only.
Result<std::unique_ptr<TouchLaw>> make_touch_wall(double stiffness_n_per_m, double damping_ns_per_m);

}  // namespace hapton
