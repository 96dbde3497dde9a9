#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/base/result.h"
#include "tools/bench/remote_grid.h"

namespace hapton {

// The columns that identify a run, the same in every table: names, values in a line, values as JSON. Pre: the key has a method.
std::string key_columns();
std::string to_csv(const RemoteKey& key);
nlohmann::ordered_json to_json(const RemoteKey& key);

// Text: for each speed and loss a table with median and worst value over meshes and seeds; then a table of the walls. RT: no.
std::string to_text(const RemoteGrid& grid, const RemoteResults& results);

// CSV, one line for each run.
std::string to_csv(const RemoteResults& results);
// CSV, one line for each wall.
std::string walls_to_csv(const RemoteResults& results);

// JSON with the schema hapton.bench.remote/1.
std::string to_json(const RemoteGrid& grid, const RemoteResults& results);

// A gnuplot script that writes the file `picture`: for each method, force error and largest stiffness of a wall against round trip, at the
// slowest speed and at a loss of 10 %, or the grid's first loss if it has no 10 %.
std::string make_remote_plot(const RemoteGrid& grid, const RemoteResults& results, const std::string& picture);
// Draws this plot and returns the path of the picture. Error: as draw_with_gnuplot.
Result<std::filesystem::path> draw_remote_plot(const std::filesystem::path& picture, const RemoteGrid& grid, const RemoteResults& results);

}  // namespace hapton
