#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "scene/table_reader.h"

namespace hapton {

// Findings of `hapton check` that may be intended, named as there. Those that concern the stability of the loop are not among them.
inline constexpr std::array<std::string_view, 8> kAcceptableFindings = {"thin-wall",  "opening",      "crack",     "flipped",
                                                                        "inside-out", "out-of-reach", "coincides", "enclosed"};
inline constexpr std::string_view kAcceptedFindingsKey = "accepted_findings";

// Reads the list of such names in an [[object]] table; empty: the table has none. name: that of the table, for errors. RT: set-up only.
// Error: one line that names the line in the file.
Result<std::vector<std::string>> read_accepted_findings(const toml::table& object, const std::string& name);

}  // namespace hapton
