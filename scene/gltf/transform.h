#pragma once

#include <string>
#include <vector>

#include "core/math/types.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/json.h"

namespace hapton::gltf {

// A node's own transform X_PN, from its frame to that of its parent: a matrix in column order, or translation, rotation and scale (glTF
// 2.0, 3.5.2). where: the node, for messages. Error: one line with `where`.
Result<Eigen::Affine3d> transform_of(const Json& node, const std::string& where);

// The rotation in such a transform: the one that the file gives, so that scale and mirroring are what remains; if the file gives a matrix,
// the rotation nearest to that matrix. Pre: X_PN is transform_of(node).
Mat3 rest_rotation_of(const Json& node, const Eigen::Affine3d& X_PN);

// The transforms of the instances of a node's mesh (EXT_mesh_gpu_instancing), in the node's frame; a single identity if the node does not
// have the extension. Error: as transform_of.
Result<std::vector<Eigen::Affine3d>> instances_of(const Json& node, const Document& document, const std::string& where);

}  // namespace hapton::gltf
