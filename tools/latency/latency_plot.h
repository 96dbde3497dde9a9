#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/base/result.h"
#include "tools/latency/latency_csv.h"

namespace hapton {

// The gnuplot script that draws for each hop the share of samples that took longer against the latency in us, on logarithmic axes, with the
// bare echo dashed, into the file `picture` of its working directory. Pre: each hop has durations. RT: set-up only.
std::string make_latency_plot(std::span<const HopCounts> hops, const std::string& picture);

// Draws folder/latency.png from folder/latency.csv and returns its path. Error, one line: no table, or that of draw_with_gnuplot.
Result<std::filesystem::path> draw_latency_plot(const std::filesystem::path& folder);

}  // namespace hapton
