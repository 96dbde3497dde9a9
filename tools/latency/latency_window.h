#pragma once

#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "tools/latency/latency_csv.h"

namespace hapton {

// The report on a part of a longer run, from the reports at its start and end: counters, hops, ratios and measured rates are those of that
// part; maxima (longest_*) and all else are those of `now`. hops: the counts of that part (subtract_hops). RT: no.
nlohmann::ordered_json make_window_report(const nlohmann::ordered_json& before, const nlohmann::ordered_json& now,
                                          const std::vector<HopCounts>& hops);

}  // namespace hapton
