#pragma once

#include "scene/gltf/accessor.h"
#include "scene/raw_mesh.h"

namespace hapton::gltf {

// Fills raw.animations with the animations of the document [3.11]: the rigid motion of each node with triangles, as it and the nodes above
// it move, and the weights of its morph targets. Between the keyframes of all these nodes the motion is straight, at constant speed, which
// is exact where only one of them moves and its sampler is LINEAR; CUBICSPLINE samplers get keyframes in between (straighten_spline). Left
// out with a note: scales other than at rest and pointers, STEP samplers that jump, and nodes that would be deformed. Pre: the parts and
// morphs of raw are complete. Error: an animation that does not fit, lies outside the file's bytes, or is more than a file of that size is
// meant to have; raw has the animations before it.
Result<void> read_animations(const Document& document, RawMesh& raw);

}  // namespace hapton::gltf
