#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hapton {

// The summary of a run.
struct RunSummary {
  bool touched = false;  // some sample was in contact
  bool held = false;     // rate, losses, late forces and faults are as they should be
  std::string text;      // two lines: what was touched; whether it held, and if not what did not
};

// From a report.json (schema kReportSchema) as read_report_json returns it; missing keys count as zero. `what`: the object to
// touch, for the text. Held: at least 99 % of the servo rate, no force lost, at most 1 % late, no fault latched, no command timeout.
// RT: no.
RunSummary summarise_run(const nlohmann::ordered_json& report, const std::string& what);

}  // namespace hapton
