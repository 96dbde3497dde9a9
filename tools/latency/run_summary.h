#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace hapton {

// The summary of a run.
struct RunSummary {
  bool has_contact = false;      // some sample was in contact
  bool has_no_troubles = false;  // no trouble was found, see below
  std::string text;              // two lines: what was touched; that no trouble was found, or which
};

// The summary of a report.json as read_report_json returns it; missing keys count as zero. `what`: name of the touched object, for
// the text. has_no_troubles: the device reaches the scene, forces came, none is lost, at most 1 % are late, no fault was latched, no
// command timed out, at least 99 % of the servo rate was reached. RT: no.
RunSummary summarise_run(const nlohmann::ordered_json& report, const std::string& what);

}  // namespace hapton
