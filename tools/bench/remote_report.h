#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/base/result.h"
#include "tools/bench/remote_grid.h"

namespace hapton {

// Which run a line is of, as every table has it: columns, a line's values, an object of JSON.
std::string key_columns();
std::string to_csv(const RemoteKey& key);
nlohmann::ordered_json to_json(const RemoteKey& key);

// Median and worst over meshes and seeds, a table for each speed and loss, and one of the walls. RT: no.
std::string to_text(const RemoteGrid& grid, const RemoteResults& results);

// A line for each run.
std::string to_csv(const RemoteResults& results);
// ... and for each wall.
std::string walls_to_csv(const RemoteResults& results);

// Schema hapton.bench.remote/1.
std::string to_json(const RemoteGrid& grid, const RemoteResults& results);

// Force error against round trip, and the largest stiffness of a wall, of each method: slowest speed, loss of 10 % or the first.
std::string make_remote_plot(const RemoteGrid& grid, const RemoteResults& results, const std::string& picture);
// Error: one line: no gnuplot, or gnuplot's message.
Result<std::filesystem::path> draw_remote_plot(const std::filesystem::path& picture, const RemoteGrid& grid, const RemoteResults& results);

}  // namespace hapton
