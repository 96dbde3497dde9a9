#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/commanded_motion.h"
#include "core/math/keyframe_motion.h"
#include "scene/object_reader.h"
#include "scene/scene_fit.h"

namespace hapton {

// The largest distance of a vertex from a point, m.
double radius_about(const Vec3& point, const TriangleMesh& mesh);

// The motion of an object of a scene file in S, by its keyframes or its animation; null: static. mesh: as touched at rest, in S after
// `fit`. RT: no. Error: one line with the line in the file: a vertex would move faster than kMaxSurfaceSpeed (the error gives the shortest
// time or highest animation_speed allowed), a loop does not end at its first pose and has no MotionSpec::seam_s, or a turn by half a turn
// between keyframes, whose direction is undefined. A looping animation that ends elsewhere returns in seam_s, with a note.
Result<std::shared_ptr<const KeyframeMotion>> make_motion(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                          const TriangleMesh& mesh, std::vector<std::string>& notes);

}  // namespace hapton
