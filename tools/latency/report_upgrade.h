#pragma once

#include <nlohmann/json_fwd.hpp>

namespace hapton {

// Gives a report of schema hapton.report/1 to /3 the names of kReportSchema; any other stays as it is. The numbers are the same in all:
// only counters, notes and rates were renamed. RT: no.
void upgrade_report(nlohmann::ordered_json& report);

}  // namespace hapton
