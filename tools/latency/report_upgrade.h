#pragma once

#include <nlohmann/json_fwd.hpp>

namespace hapton {

// Gives a report of schema hapton.report/1 the names of kReportSchema; any other stays as it is. The numbers are the same in both: only
// counters and notes were renamed. RT: no.
void upgrade_report(nlohmann::ordered_json& report);

}  // namespace hapton
