#pragma once

#include <cstdint>
#include <vector>

#include "vision_node/flat_level.h"

namespace hapton {

// Sorts triangles that show what is behind them for drawing: from the farthest to the nearest, by their centres; equally far ones keep
// their order. Triangles that intersect, or that are long compared with their distance from each other, may have no right order, or get a
// wrong one. All in the level's frame U; p_UE: the eye. RT: no.
void sort_far_to_near(std::vector<std::uint32_t>& indices, const std::vector<FlatVertex>& vertices, const Vec3f& p_UE);

// The numbers of the clusters in the same order.
std::vector<std::uint32_t> order_far_to_near(const std::vector<DetailCluster>& clusters, const Vec3f& p_UE);

}  // namespace hapton
