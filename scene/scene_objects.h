#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "scene/object_reader.h"

namespace hapton {

// Reads all objects of a scene file: the tables [[object]], [[group]] and [[instance]], as plain objects with their poses in S. materials:
// the names of the materials that the file defines. RT: set-up only. Error: one line with the line in the file.
Result<std::vector<ObjectSpec>> read_scene_objects(const toml::table& scene, std::span<const std::string_view> materials);

}  // namespace hapton
