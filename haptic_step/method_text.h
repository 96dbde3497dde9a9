#pragma once

#include <string>
#include <string_view>

#include "core/force/force_method.h"

namespace hapton {

// A method and its settings as text for a recording: "name=proxy probe_radius_m=0.001"; defaults are left out. Numbers keep every bit. RT:
// set-up only.
std::string to_text(const MethodSettings& settings);

// Error: a key that to_text does not write, a malformed value.
Result<MethodSettings> parse_method_text(std::string_view text);

// What stands behind "effects=" there: the effects from shared libraries that were added (PluginEffects::to_text). Empty: none.
std::string_view effects_in(std::string_view method_text);

}  // namespace hapton
