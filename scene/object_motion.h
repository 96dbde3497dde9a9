#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/keyframe_motion.h"
#include "scene/object_reader.h"
#include "scene/scene_fit.h"

namespace hapton {

// No surface pushes a hand faster than this, m/s: that of a robot with people beside it (reduced speed of ISO 10218-1).
constexpr double kMostSurfaceSpeed = 0.25;

// The motion of an object of a scene file in S, by its keyframes or its animation; null: it stands still. mesh: as it is touched at rest,
// in S after `fit`. RT: no. Error: one line with the line in the file: a vertex would move faster than kMostSurfaceSpeed (the least time
// that allows it is named), the end is not the beginning of a loop, half a turn at once, which has no direction.
Result<std::shared_ptr<const KeyframeMotion>> make_motion(const ObjectSpec& object, const std::string& name, const SceneFit& fit,
                                                          const TriangleMesh& mesh);

}  // namespace hapton
