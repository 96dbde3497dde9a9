#pragma once

#include <vector>

#include "bench/measure/mesh_run.h"
#include "bench/measure/numbers_run.h"

namespace hapton {

// The rows of one mesh, with the goals of the rough sphere: call it for that mesh only.
std::vector<NumberRow> rows_of_mesh(const MeshFigures& figures, const MeshRunSettings& settings);

// Median and worst mesh of each quantity, and totals over all meshes. Pre: not empty, of one probe, all with or all without
// friction.
std::vector<NumberRow> rows_over_meshes(const std::vector<MeshFigures>& all, const MeshRunSettings& settings);

}  // namespace hapton
