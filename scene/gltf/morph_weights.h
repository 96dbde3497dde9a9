#pragma once

#include <string>
#include <vector>

#include "scene/gltf/json.h"

namespace hapton::gltf {

// The weights of the morph targets of a node at rest: its own, or those of its mesh, or none [3.7.2.2, 3.5.2]. Pre: node is an element of
// the document's nodes and has a mesh of the document. Error: something that is not a finite number.
Result<std::vector<double>> weights_at_rest(const Json& root, const Json& node, const std::string& where);

}  // namespace hapton::gltf
