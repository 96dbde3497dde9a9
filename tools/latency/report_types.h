#pragma once

#include <nlohmann/json_fwd.hpp>

namespace hapton {

// Whether those of hops, counters, rates_hz, ratios, notes and seconds that are present have the types of a report (docs/formats.md), so
// that nlohmann's json can be read without exceptions. The schema is not checked. RT: no.
bool has_report_types(const nlohmann::ordered_json& report);

}  // namespace hapton
