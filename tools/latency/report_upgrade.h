#pragma once

#include <nlohmann/json_fwd.hpp>

namespace hapton {

// Changes a report of schema hapton.report/1 to /3 to the names of kReportSchema; any other JSON stays as it is. These schemas differ only
// in the names of counters, notes and rates; the values stay. RT: no.
void upgrade_report(nlohmann::ordered_json& report);

}  // namespace hapton
