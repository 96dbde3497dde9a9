#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Things of the scene that are where nobody feels or sees them as they are meant: an object in the place of an equal one; an object
// altogether inside another one, whose closed surface keeps the probe out of it; the camera, or a light at a position, inside a closed
// body. Objects that move, deform, are carved or picked up count as neither; nor does a body with layers keep the probe out, nor one to
// carve. An object is inside if its vertices are: of a large one, kMaxPlaces of them. S lies on W: the knob box is at zero. RT: set-up
// only.
CheckFindings check_places(const Scene& scene);
inline constexpr std::size_t kMaxPlaces = 2000;  // a choice; more would take long with many objects inside one another

// Finds friction of which no dry surface is capable: usually a point was left out (8 for 0.8). RT: set-up only.
CheckFindings check_friction(const SceneObject& object);
// A choice: rubber on dry concrete has about 1, a tip that is glued to a soft surface more.
inline constexpr double kMaxFriction = 2.0;

}  // namespace hapton
