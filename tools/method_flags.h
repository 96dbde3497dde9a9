#pragma once

#include <string>

#include "core/base/result.h"
#include "core/force/force_method.h"
#include "scene/unit.h"
#include "tools/command_line.h"

namespace hapton {

// A method and its settings as a command line says them; the names of the flags are haptics_node's.
struct MethodFlags {
  MethodSettings settings;
  std::string grid = "32";
  std::string simplify = "0";
  double offset_in = MethodSettings{}.offset_m / metres_per(Unit::in);
};

// --method, --probe-radius, and what single methods read. Pre: `flags` outlives the parsing.
void add_method_flags(CommandLine command, MethodFlags& flags);

// Error: a grid that is not a division, a bound that is not a length.
Result<MethodSettings> settings_of(const MethodFlags& flags);

}  // namespace hapton
