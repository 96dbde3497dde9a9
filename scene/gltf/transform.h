#pragma once

#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// A node's own transform, to its parent: a matrix in column order, or translation, rotation and scale (glTF 2.0, 3.5.2). where: the node,
// for messages. Error: one line with `where`.
Result<Eigen::Affine3d> transform_of(const Json& node, const std::string& where);

// The rotation in it: that of the file, so that scale and mirroring are the rest; of a matrix, which does not say it, the nearest one.
// Pre: transform_of(node) is X_PN.
Mat3 rest_rotation_of(const Json& node, const Eigen::Affine3d& X_PN);

// The transforms of the instances of a node's mesh (EXT_mesh_gpu_instancing), in the node's frame; a single identity if the node does not
// have the extension. Error: as above.
Result<std::vector<Eigen::Affine3d>> instances_of(const Json& node, const Document& document, const std::string& where);

}  // namespace hapton::gltf
