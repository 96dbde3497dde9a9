#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// A [[probe]] of a scene file: how one hand touches the scene. What it leaves out is as haptics_node has it by default.
struct ProbeSpec {
  std::string name;
  std::optional<double> radius_m = {};  // 0: a point
  std::optional<std::string> method = {};
  std::optional<double> shading = {};
  std::size_t line = 0;  // in the scene file
};

// The probe of this name; an empty name is that of the first one. Null: there is none. RT: set-up only. Error: there are probes, or a name
// was given, and none has it: one line.
Result<const ProbeSpec*> find_probe(const std::vector<ProbeSpec>& probes, std::string_view name);

// "probe 'left': radius 0.002 m, method proxy".
std::string describe(const ProbeSpec& probe);

}  // namespace hapton
