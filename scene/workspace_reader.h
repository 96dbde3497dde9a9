#pragma once

#include <optional>

#include "core/base/result.h"
#include "scene/similarity.h"
#include "scene/table_reader.h"

namespace hapton {

// The table [workspace] of a scene file: where the workspace of the device is in the scene, and how large. A point p of W is at apply(p) in
// the scene as the file describes it. None: the file has no such table. RT: set-up only. Error: one line with the line in the file.
Result<std::optional<Similarity>> read_workspace(const toml::table& scene);

}  // namespace hapton
