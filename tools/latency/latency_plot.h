#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/base/result.h"
#include "tools/latency/latency_csv.h"

namespace hapton {

// The gnuplot script that draws the hops as curves of "share of samples slower than", both axes logarithmic, in us, the bare echo dashed,
// into the file `picture` of the folder it runs in. RT: set-up only.
std::string make_latency_plot(std::span<const HopCounts> hops, const std::string& picture);

// Draws folder/latency.png from folder/latency.csv. Error: one line: no table, no gnuplot, or gnuplot's message.
Result<std::filesystem::path> draw_latency_plot(const std::filesystem::path& folder);

}  // namespace hapton
