#pragma once

#include "scene/scene_file.h"
#include "vision_node/detail_levels.h"

namespace hapton {

// Whether triangles of an object that are seen from behind belong in the picture: both sides of its surface are felt, and the surface is
// not closed with its fronts outside; or a material of its file is not opaque and is seen from both sides. Never for an object that can be
// carved. Otherwise they are always hidden, and not drawing them saves time. Linear in the mesh. RT: set-up only.
bool shows_backs(const SceneObject& object);

// Marks the vertices of a mesh's full level that no eye sees from behind (DetailLevel::without_back): those of its closed bodies with their
// fronts outside. Marks none if the appearance shows inner sides. appearance: may be null. Linear in the mesh. RT: set-up only.
void mark_without_back(const TriangleMesh& mesh, const MeshAppearance* appearance, DetailLevel& full);

}  // namespace hapton
