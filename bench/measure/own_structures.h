#pragma once

#include <vector>

#include "bench/measure/query_structure.h"

namespace hapton {

// Hapton's structures for the benchmarks of queries: brute force in float and double, the uniform grid of the memo with 8 .. 128 cells
// along each axis, Fixed Direction Hulls of 6, 14, 18 and 26 directions, and the BVH with eight children per node. RT: set-up only.
std::vector<QueryStructureKind> own_structures();

}  // namespace hapton
