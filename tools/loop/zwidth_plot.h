#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/loop/zwidth_grid.h"

namespace hapton {

// The gnuplot script: largest stable stiffness (solid) and largest passive stiffness (dashed) against delay, or against rate if the grid
// has one delay and several rates. A colour for each device, hand and rate (or delay, wall damping, jitter, loss). picture: file to draw.
std::string make_zwidth_plot(const ZWidthGrid& grid, const std::vector<ZWidthRow>& rows, const std::string& picture);

// Draws it with gnuplot, and returns what draw_with_gnuplot returns. Error: as there. RT: no.
Result<std::filesystem::path> draw_zwidth_plot(const std::filesystem::path& picture, const ZWidthGrid& grid,
                                               const std::vector<ZWidthRow>& rows);

}  // namespace hapton
