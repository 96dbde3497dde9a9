#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// A [[probe]] of a scene file: how one hand touches the scene. Missing keys keep the defaults of haptics_node.
struct ProbeSpec {
  std::string name;
  std::optional<double> radius_m = {};  // 0: a point
  std::optional<std::string> method = {};
  std::optional<double> shading = {};  // 0: the force has the direction of face normals; 1: of smooth normals
  std::size_t line = 0;                // in the scene file
};

// The probe of this name; for an empty name the first one, or null if there are no probes. Error, one line: a name is given, but no
// probe has it. RT: set-up only.
Result<const ProbeSpec*> find_probe(const std::vector<ProbeSpec>& probes, std::string_view name);

// "probe 'left': radius 0.002 m, method proxy".
std::string describe(const ProbeSpec& probe);

}  // namespace hapton
