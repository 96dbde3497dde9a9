#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/measure/pareto_run.h"
#include "core/base/result.h"

namespace hapton {

// The gnuplot script that draws time against error, both logarithmic, a panel per mesh, a mark per method family, and the Pareto front as a
// line, into the file `picture` of the folder it runs in. RT: set-up only.
std::string make_pareto_plot(const std::vector<ParetoMark>& marks, const std::string& picture);

// Draws folder/pareto.png. Error: one line: nothing to draw, no gnuplot, or gnuplot's message.
Result<std::filesystem::path> draw_pareto_plot(const std::filesystem::path& folder, const std::vector<ParetoMark>& marks);

}  // namespace hapton
