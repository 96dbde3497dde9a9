#pragma once

#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// A node's own transform: a matrix, column by column, or T R S [3.5.2].
Result<Eigen::Affine3d> transform_of(const Json& node, const std::string& where);

// The poses in the node's frame at which EXT_mesh_gpu_instancing draws its mesh: T R S of each instance. One that is the identity when the
// node has no such extension.
Result<std::vector<Eigen::Affine3d>> instances_of(const Json& node, const Document& document, const std::string& where);

}  // namespace hapton::gltf
