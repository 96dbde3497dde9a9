#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.h"

namespace hapton {

// Reads the report.json of a run; path: the file or its folder. Error, one line: it cannot be read, or it is not a report. RT: no.
Result<nlohmann::ordered_json> read_report_json(const std::filesystem::path& path);

// Compares two runs, A and B: p50, p99, p99.9 and max of each hop that both have, all ratios and rates, and the counters that differ; each
// with the ratio B / A. As a table for people, and as JSON (schema hapton.latency-compare/1). Pre: from read_report_json. RT: no.
std::string compare_text(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);
nlohmann::ordered_json compare_json(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);

}  // namespace hapton
