#pragma once

#include <vector>

#include "bench/measure/mesh_run.h"
#include "bench/measure/numbers_run.h"

namespace hapton {

// The rows of one mesh, with the goals for the rough sphere: call it only for that mesh.
std::vector<NumberRow> rows_of_mesh(const MeshFigures& figures, const MeshRunSettings& settings);

// For each quantity the median over the meshes and the worst mesh, and totals over all meshes. Pre: `all` is not empty; its figures are for
// one probe, and all with or all without friction.
std::vector<NumberRow> rows_over_meshes(const std::vector<MeshFigures>& all, const MeshRunSettings& settings);

}  // namespace hapton
