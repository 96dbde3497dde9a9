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

// How an object of a scene file deforms, by its morphs or its animation, of its mesh in S; null: it is rigid. in_file: its vertices in the
// file's frame; mesh: as it is touched at rest, in S after `fit`. motion: that of the object, null if it has none. RT: no. Error: one line
// with the line in the file: a vertex would move faster than kMaxSurfaceSpeed together with the motion (the time that would do is named),
// the end is not the beginning of a loop, a surface that touches itself in some shape (check_shapes), morphs that move nothing; of an
// animation, a mesh that was sealed where it deforms, or would be torn.
Result<std::shared_ptr<const MeshDeformation>> make_deformation(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                                const std::vector<Vec3>& in_file, const TriangleMesh& mesh,
                                                                const KeyframeMotion* motion);

}  // namespace hapton
