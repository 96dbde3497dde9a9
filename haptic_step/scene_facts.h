#pragma once

#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// The message with which a haptics node describes its scene to the other nodes. RT: set-up only.
SceneFacts make_scene_facts(const Scene& scene);

}  // namespace hapton
