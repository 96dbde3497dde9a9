#pragma once

#include <string>
#include <vector>

#include "bench/measure/sixdof_method.h"

namespace hapton {

// Rigid tools by other libraries that were found when this was built; empty with HAPTON_BENCH_PEERS=OFF.
std::vector<SixdofMethodKind> tool_peers();
// Those that a comparison would show but that this was built without: "fcl", "bullet".
std::vector<std::string> missing_tool_peers();

// Bullet: a body of 100 g on a critically damped spring, meshes against meshes by GImpact, steps of 1 ms. One file each:
// bench/peers/<library>_tool.cpp.
SixdofMethodKind bullet_tool();
// FCL: continuous collision from where the tool is to the device; the tool stops at the first contact, for FCL says no more than when.
SixdofMethodKind fcl_tool();

}  // namespace hapton
