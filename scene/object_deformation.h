#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/mesh_deformation.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/keyframe_motion.h"
#include "scene/object_reader.h"
#include "scene/scene_fit.h"

namespace hapton {

// How an object of a scene file deforms, by its morphs or its animation, in S; null: it is rigid. in_file: for an animation, its vertices
// in the file's frame; mesh: as it is touched at rest, in S after `fit`. motion: that of the object, null if it has none. RT: no. Error:
// one line with the line in the file: a vertex would move faster than kMaxSurfaceSpeed, motion included; a loop whose last weights are not
// its first; a surface that touches itself in some shape (check_shapes); a morph that moves no vertex; for an animation: cracks were
// sealed, the mesh would be torn, more than kMaxTargets targets.
Result<std::shared_ptr<const MeshDeformation>> make_deformation(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                                const std::vector<Vec3>& in_file, const TriangleMesh& mesh,
                                                                const KeyframeMotion* motion);

// A deformation by the morphs of a scene file as it would be of other vertices, in S after `fit`. Pre: make_deformation made one of this
// object by its morphs.
MeshDeformation deform_others(const ObjectSpec& object, const SceneFit& fit, const std::vector<Vec3>& vertices);

}  // namespace hapton
