#pragma once

#include "scene/scene_file.h"
#include "vision_node/detail_levels.h"

namespace hapton {

// Whether triangles of an object that are seen from behind belong in the picture: both sides of its surface are felt, and the surface is
// not closed with its fronts outside; or its file says that a material with transparency is seen from both sides. Otherwise they are
// always hidden, and leaving them out saves time. Linear in the mesh. RT: set-up only.
bool shows_backs(const SceneObject& object);

// Marks the vertices of the full level of a mesh that no eye sees from behind (DetailLevel::without_back): of its closed bodies with their
// fronts outside, unless the look shows inner sides. look: null: none. Linear in the mesh. RT: set-up only.
void mark_without_back(const TriangleMesh& mesh, const MeshAppearance* appearance, DetailLevel& full);

}  // namespace hapton
