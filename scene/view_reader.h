#pragma once

#include "core/base/result.h"
#include "scene/scene_view.h"
#include "scene/table_reader.h"

namespace hapton {

// The table [camera] and the tables [[light]] of a scene file. RT: set-up only. Error: one line with the line in the file.
Result<SceneView> read_view(const toml::table& scene);

}  // namespace hapton
