#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "tools/latency/latency_csv.h"

namespace hapton {

// A part of a longer run, from two of its reports: counters as they rose, rates, hops and ratios of the time between, all else as it is
// now. hops: what was counted in between (subtract_hops). RT: no.
nlohmann::ordered_json make_window_report(const nlohmann::ordered_json& before, const nlohmann::ordered_json& now,
                                          const std::vector<HopCounts>& hops);

}  // namespace hapton
