#pragma once

#include <string>
#include <vector>

#include "bench/measure/query_structure.h"

namespace hapton {

// The structures of other libraries that were found when this was built; empty with HAPTON_BENCH_PEERS=OFF.
std::vector<QueryStructureKind> peer_structures();

// Libraries that belong to the comparison but that this was built without: "embree", "cgal", "fcl", "vtk".
std::vector<std::string> missing_peers();

// Each is defined in a file of its own: bench/peers/<library>_structures.cpp.
std::vector<QueryStructureKind> embree_structures();
std::vector<QueryStructureKind> cgal_structures();
std::vector<QueryStructureKind> fcl_structures();
std::vector<QueryStructureKind> vtk_structures();

}  // namespace hapton
