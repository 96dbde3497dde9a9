#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/mesh_appearance.h"
#include "vision_node/detail_levels.h"

namespace hapton {

// Makes a level of the mesh in full detail, with paint: one vertex for each pair of mesh vertex and paint, so that two vertices are at the
// same point where colours or images meet. colour: sRGB, for surfaces without a colour or image of their own. layer_of: for each image of
// the appearance its layer in the texture, from 1; 0: none. Pre: appearance has as many triangles as the mesh. RT: set-up only.
DetailLevel make_painted_level(const TriangleMesh& mesh, const DetailFrame& frame, const MeshAppearance& appearance, const Vec3& colour,
                               const std::vector<std::uint8_t>& layer_of);

}  // namespace hapton
