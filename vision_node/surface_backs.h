#pragma once

#include "scene/scene_file.h"

namespace hapton {

// Whether triangles of an object that are seen from behind belong in the picture: both sides of its surface are felt, and the surface is
// not closed with its fronts outside; or its file says that a material with transparency is seen from both sides. Otherwise they are
// always hidden, and leaving them out saves time. Linear in the mesh. RT: set-up only.
bool shows_backs(const SceneObject& object);

}  // namespace hapton
