#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Finds flaws of the scene's rigid tool; surfaces with effects that it, or an object that the stylus picks up, does not feel; and movable
// objects that overlap or touch another one where the scene file places them. Empty if the scene has neither a tool nor movable objects.
// Error: haptics_node rejects the tool. RT: no; it builds the contact structures of the tool, each movable object and the others.
Result<CheckFindings> check_tool(const Scene& scene);

// The rotational stiffness about the grip point of the scene's rigid tool or, without a tool, of each movable object, as haptics_node
// derives it from size and stiffest surface. A movable object may be held anywhere: the grip with the largest stiffness counts. RT: no.
struct RotationalStiffness {
  std::string name;
  double nm_per_rad = 0.0;
};
std::vector<RotationalStiffness> list_rotational_stiffness(const Scene& scene);

}  // namespace hapton
