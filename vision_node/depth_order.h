#pragma once

#include <cstdint>
#include <vector>

#include "vision_node/flat_level.h"

namespace hapton {

// The order of drawing what shows through: from the farthest to the nearest, by centres; what is equally far keeps its order. Triangles
// that intersect, or that are long beside their distance from each other, have no such order: theirs may be wrong. All in the level's frame
// U; p_UE: the eye. RT: no.
void sort_far_to_near(std::vector<std::uint32_t>& indices, const std::vector<FlatVertex>& vertices, const Vec3f& p_UE);

// The numbers of the clusters in that order.
std::vector<std::uint32_t> order_far_to_near(const std::vector<DetailCluster>& clusters, const Vec3f& p_UE);

}  // namespace hapton
