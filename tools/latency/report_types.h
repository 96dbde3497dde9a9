#pragma once

#include <nlohmann/json_fwd.hpp>

namespace hapton {

// Whether hops, counters, rates_hz, ratios, notes and seconds have the types of a report (docs/formats.md), as far as they are there: only
// then do nlohmann's readers not throw. Of any schema. RT: no.
bool has_report_types(const nlohmann::ordered_json& report);

}  // namespace hapton
