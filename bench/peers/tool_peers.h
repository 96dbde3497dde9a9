#pragma once

#include <string>
#include <vector>

#include "bench/measure/sixdof_method.h"

namespace hapton {

// Rigid tools by other libraries that were found when this was built; empty with HAPTON_BENCH_PEERS=OFF.
std::vector<SixdofMethodKind> tool_peers();
// Libraries that belong to the comparison but that this was built without: "fcl", "bullet".
std::vector<std::string> missing_tool_peers();

// Bullet: a body of 100 g on a critically damped spring, meshes against meshes by GImpact, steps of 1 ms. Each tool is defined in a file of
// its own: bench/peers/<library>_tool.cpp.
SixdofMethodKind bullet_tool();
// FCL: continuous collision from the tool's pose to the device's; the tool stops at the first contact, because FCL reports only its time.
SixdofMethodKind fcl_tool();

}  // namespace hapton
