#pragma once

#include "core/force/touch_scene.h"

namespace hapton {

// The largest stiffness that can act on the hand, N/m, for the stiffness warning; 0: none. RT: no.

// Of a surface: the spring or the layers, plus the progressive stiffness at 10 N of its progressive part; or the snap, if that is stiffer.
double stiffest_of(const Material& material, const SurfaceEffects& effects);
// Of a spring or a snap; other effects have no stiffness.
double stiffest_of(const SpaceEffect& effect);
double find_stiffest(const TouchScene& scene);

}  // namespace hapton
