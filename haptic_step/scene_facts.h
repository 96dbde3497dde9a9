#pragma once

#include "link/messages.h"
#include "scene/scene_file.h"

namespace hapton {

// What a haptics node tells the others of its scene. RT: set-up only.
SceneFacts make_scene_facts(const Scene& scene);

}  // namespace hapton
