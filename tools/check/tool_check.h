#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/scene_file.h"
#include "tools/check/check_finding.h"

namespace hapton {

// Flaws of the scene's rigid tool, and what it, or an object that the stylus picks up, meets in the scene: surfaces of which it feels only
// the shape, and movable objects that overlap or touch another one where they lie. Nothing where the scene has neither a tool nor movable
// objects. Error: haptics_node rejects the tool. RT: no; builds the tool, each movable object and the others for contact.
Result<CheckFindings> check_tool(const Scene& scene);

// How stiffly the scene's rigid tool, or an object that the stylus picks up, turns about its grip, as haptics_node derives it from its size
// and the stiffest surface. An object may be held anywhere: at the place where it turns most stiffly. RT: no.
struct TurnedBody {
  std::string name;
  double nm_per_rad = 0.0;
};
std::vector<TurnedBody> list_turned(const Scene& scene);

}  // namespace hapton
