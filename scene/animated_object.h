#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "scene/mesh_file.h"
#include "scene/object_reader.h"

namespace hapton {

// Splits an object that plays an animation of its glTF file: first one object with its own name for the nodes that stand still; then one
// for each motion, with all nodes that move so, or for each node that deforms, named "NAME/NODE" after the first node. If object.part is
// given, only the nodes of that name. RT: no. Error: the file has no such animation (it names those), or it moves nothing of the object.
Result<std::vector<ObjectSpec>> split_animated(const ObjectSpec& object, const std::string& name, const MeshFile& file);

}  // namespace hapton
