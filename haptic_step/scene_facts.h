#pragma once

#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// The scene facts that a haptics node sends to the others. RT: set-up only.
SceneFacts make_scene_facts(const Scene& scene);

}  // namespace hapton
