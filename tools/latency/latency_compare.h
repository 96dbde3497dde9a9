#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/result.h"

namespace hapton {

// Reads a run's report.json: the file itself, or the folder that it is in. Error: one line: cannot be read, is not a report.
Result<nlohmann::ordered_json> read_report_json(const std::filesystem::path& path);

// Two runs side by side: of each hop that both have p50, p99, p99.9 and max of A and B and their ratio B / A, of the ratios and the
// counters that differ both values. As a table, and as JSON (schema hapton.latency-compare/1). RT: no.
std::string compare_text(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);
nlohmann::ordered_json compare_json(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b);

}  // namespace hapton
