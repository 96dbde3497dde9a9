#pragma once

#include <vector>

#include "bench/measure/query_structure.h"

namespace hapton {

// Hapton's structures: brute force in float and double, the memo's grid of 8 .. 128 cells along each axis, Fixed Direction Hulls of 6, 14,
// 18 and 26 directions, and the eight-wide BVH.
std::vector<QueryStructureKind> own_structures();

}  // namespace hapton
