#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/mesh_file.h"
#include "scene/object_reader.h"

namespace hapton {

// What an object becomes that plays an animation of its glTF file: an object for each motion, with all nodes that move so, named after the
// first of them, "NAME/NODE"; and one with its own name for the nodes that stand still. Of `part` only the nodes of that name.
// RT: no. Error: the file has no such animation, or it moves nothing of the object; names those there are.
Result<std::vector<ObjectSpec>> split_animated(const ObjectSpec& object, const std::string& name, const MeshFile& file);

}  // namespace hapton
