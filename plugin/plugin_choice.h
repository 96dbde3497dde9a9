#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// A plug-in as a command line names it: FILE.so, or FILE.so:KEY=VALUE,KEY=VALUE.
struct PluginChoice {
  std::string file;
  std::vector<std::pair<std::string, std::string>> parameters = {};

  // The plug-in in that form again.
  std::string to_text() const;
};

// RT: set-up only. Error: one line: no file, a parameter without a value, a parameter that is given twice.
Result<PluginChoice> parse_plugin_choice(std::string_view text);

}  // namespace hapton
