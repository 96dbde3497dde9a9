#pragma once

#include "core/force/touch_scene.h"

namespace hapton {

// The largest stiffness that can be felt, N/m, for advice on what a loop holds; 0: none. RT: no.

// Of a surface: its spring or its layers, with progressive stiffness at 10 N of its progressive part, or what snaps to it.
double stiffest_of(const Material& material, const SurfaceEffects& effects);
// Of a spring or a snap; others have no stiffness.
double stiffest_of(const SpaceEffect& effect);
double find_stiffest(const TouchScene& scene);

}  // namespace hapton
