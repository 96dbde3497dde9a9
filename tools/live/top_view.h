#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/latency/latency_csv.h"

namespace hapton {

// A hub's report at one moment.
struct TopSnapshot {
  nlohmann::ordered_json report;
  std::vector<HopCounts> hops;
};

// Reads the two texts of a HubReport. Error: json has another schema than this build's reports. A csv that cannot be read gives no hops.
Result<TopSnapshot> read_top_snapshot(const std::string& json, const std::string& csv);

// What `hapton top` shows: nodes with their datagrams a second, hops, counters that are not zero. Rates, hops and the second column of the
// counters are for the time between the two snapshots; without an earlier one, or after a restart of the hub, since the hub's start.
// touched: what the hand touches, shown in a line of its own; empty: no such line. RT: no.
std::string make_top_view(const std::string& hub, const TopSnapshot& now, const TopSnapshot* before, const std::string& touched = {});

// The same for programs, one JSON object in one line: schema (hapton.top/1), hub, span_s (the time over which per_second is computed),
// per_second (of each counter), touched, and report (docs/formats.md), which counts from the hub's start. RT: no.
std::string make_top_json(const std::string& hub, const TopSnapshot& now, const TopSnapshot* before, const std::string& touched = {});

}  // namespace hapton
