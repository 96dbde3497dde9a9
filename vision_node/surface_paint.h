#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/mesh_appearance.h"
#include "vision_node/detail_levels.h"

namespace hapton {

// The mesh itself as one level, painted: a vertex for each place and paint, so that where colours or images meet, two vertices lie in one
// place. colour: sRGB, of what has none of its own. layer_of: for each image of the look the layer of texture it is in, from 1; 0: none.
// Pre: the look has as many triangles as the mesh. RT: set-up only.
DetailLevel make_painted_level(const TriangleMesh& mesh, const DetailFrame& frame, const MeshAppearance& appearance, const Vec3& colour,
                               const std::vector<std::uint8_t>& layer_of);

}  // namespace hapton
