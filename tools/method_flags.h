#pragma once

#include <string>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "scene/unit.h"
#include "tools/command_line.h"

namespace hapton {

// A method and its settings as given on a command line; the flags have the names of haptics_node's.
struct MethodFlags {
  MethodSettings settings;
  std::string grid = "32";
  std::string simplify = "0";
  double offset_in = MethodSettings{}.offset_m / metres_per(Unit::in);
};

// Adds --method, --probe-radius and the flags that only single methods use. Pre: `flags` outlives the parsing.
void add_method_flags(CommandLine command, MethodFlags& flags);

// Converts the flags. Error: --grid is not N or NxNxN, or --simplify is not a length.
Result<MethodSettings> settings_of(const MethodFlags& flags);

}  // namespace hapton
