#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench/measure/sixdof_run.h"
#include "core/base/result.h"

namespace hapton {

// The gnuplot script that draws time against force error of a rigid tool, both logarithmic: a panel for each scenario whose force is known,
// a mark for each method. gnuplot writes the file `picture` in its working folder. RT: set-up only.
std::string make_sixdof_plot(const std::vector<SixdofRow>& rows, const std::string& picture);

// Draws folder/sixdof.png and returns its path. Error, one line: nothing to draw, no gnuplot, or gnuplot's message.
Result<std::filesystem::path> draw_sixdof_plot(const std::filesystem::path& folder, const std::vector<SixdofRow>& rows);

}  // namespace hapton
