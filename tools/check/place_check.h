#pragma once

#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Finds what nobody can feel or see as it is meant: an object in the same place as an equal one; an object wholly inside another one, whose
// closed surface keeps the probe out; the camera, or a light at a position, inside a closed body. Objects that can move, deform, be carved
// or be picked up are left out, on the inside and on the outside; a body with layers does not keep the probe out. An object counts as
// inside if its vertices are, at most kMaxPlaces of them, evenly spaced in the list. The knob box is at zero, so S equals W. RT: set-up
// only.
CheckFindings check_places(const Scene& scene);
inline constexpr std::size_t kMaxPlaces = 2000;  // a choice; more would take long with many objects inside one another

// Finds static friction above kMaxFriction, which no dry surface has: usually the decimal point is missing (8 for 0.8). RT: set-up only.
CheckFindings check_friction(const SceneObject& object);
// A choice: rubber on dry concrete has about 1, a tip that is glued to a soft surface more.
inline constexpr double kMaxFriction = 2.0;

}  // namespace hapton
