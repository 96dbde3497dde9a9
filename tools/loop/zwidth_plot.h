#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/loop/zwidth_grid.h"

namespace hapton {

// Largest stable stiffness (lines) and largest passive one (dashed) against delay; against rate where the grid has one delay. A colour for
// each device, hand and rate (or delay, wall damping, jitter, loss).
std::string make_zwidth_plot(const ZWidthGrid& grid, const std::vector<ZWidthRow>& rows, const std::string& picture);

// Draws it with gnuplot. Error: one line. RT: no.
Result<std::filesystem::path> draw_zwidth_plot(const std::filesystem::path& picture, const ZWidthGrid& grid,
                                               const std::vector<ZWidthRow>& rows);

}  // namespace hapton
