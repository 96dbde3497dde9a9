#pragma once

#include <string>
#include <vector>

#include "scene/gltf/json.h"

namespace hapton::gltf {

// The weights of a node's morph targets at rest: those of the node, or else those of its mesh; empty if neither has any (glTF 2.0, 3.7.2.2
// and 3.5.2). Pre: node is an element of the document's nodes and has a mesh of the document. Error: something that is not a finite number.
Result<std::vector<double>> weights_at_rest(const Json& root, const Json& node, const std::string& where);

}  // namespace hapton::gltf
