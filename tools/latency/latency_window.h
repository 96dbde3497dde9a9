#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "tools/latency/latency_csv.h"

namespace hapton {

// A part of a longer run, from two of its reports: increases of the counters; rates, hops and ratios of the time between; all else as at
// the end. hops: the counts in between (subtract_hops). RT: no.
nlohmann::ordered_json make_window_report(const nlohmann::ordered_json& before, const nlohmann::ordered_json& now,
                                          const std::vector<HopCounts>& hops);

}  // namespace hapton
