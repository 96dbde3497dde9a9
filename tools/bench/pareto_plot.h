#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/measure/pareto_run.h"
#include "core/base/result.h"

namespace hapton {

// The gnuplot script that draws time against error, both logarithmic: a panel for each mesh, a mark for each method family, and the Pareto
// front as a line. gnuplot writes the file `picture` in its working folder. RT: set-up only. Pre: marks is not empty.
std::string make_pareto_plot(const std::vector<ParetoMark>& marks, const std::string& picture);

// Draws folder/pareto.png and returns its path. Error, one line: nothing to draw, no gnuplot, or gnuplot's message.
Result<std::filesystem::path> draw_pareto_plot(const std::filesystem::path& folder, const std::vector<ParetoMark>& marks);

}  // namespace hapton
