#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "core/force/force_method.h"
#include "core/tool/tool_step.h"

namespace hapton {

// A method and its settings as text for a recording: "name=proxy probe_radius_m=0.001"; defaults are left out. Numbers keep every bit. RT:
// set-up only.
std::string to_text(const MethodSettings& settings);

// Reads such a text; the keys "effects" and "cut", which a recording adds, are ignored. Error: another unknown key, or a malformed value.
Result<MethodSettings> parse_method_text(std::string_view text);

// A rigid tool, which takes the place of a method, as text: "name=tool stiffness_n_per_m=800 ...". voxel_m 0: the tool uses no voxels.
std::string to_text(const ToolCoupling& coupling, std::size_t tool_triangles, double voxel_m = 0.0);

// Reads the text of a tool. None: the text names a method, or to_text did not write it.
std::optional<ToolCoupling> parse_tool_text(std::string_view text);

// The value of "effects=" in a method text: the effects from shared libraries that were added (PluginEffects::to_text). Empty: none.
std::string_view effects_in(std::string_view method_text);

}  // namespace hapton
