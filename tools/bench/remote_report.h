#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/base/result.h"
#include "tools/bench/remote_grid.h"

namespace hapton {

// The columns that tell which run a line belongs to, the same in every table: their names, their values in a line, the same as JSON.
std::string key_columns();
std::string to_csv(const RemoteKey& key);
nlohmann::ordered_json to_json(const RemoteKey& key);

// Text: for each speed and loss a table with the median and the worst over meshes and seeds, then a table of the walls. RT: no.
std::string to_text(const RemoteGrid& grid, const RemoteResults& results);

// CSV, a line for each run.
std::string to_csv(const RemoteResults& results);
// CSV, a line for each wall.
std::string walls_to_csv(const RemoteResults& results);

// Schema hapton.bench.remote/1.
std::string to_json(const RemoteGrid& grid, const RemoteResults& results);

// Script for gnuplot that draws, for each method, force error and largest stiffness of a wall against round trip into the file `picture`:
// at the slowest speed, and at a loss of 10 %, or the grid's first loss if it has no 10 %.
std::string make_remote_plot(const RemoteGrid& grid, const RemoteResults& results, const std::string& picture);
// Draws this plot and returns the picture's path. Error: as draw_with_gnuplot.
Result<std::filesystem::path> draw_remote_plot(const std::filesystem::path& picture, const RemoteGrid& grid, const RemoteResults& results);

}  // namespace hapton
