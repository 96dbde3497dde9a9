#pragma once

#include "core/force/force_method.h"
#include "core/geometry/triangle_mesh.h"
#include "core/math/types.h"

namespace hapton {

// Whether the reference (point probe, without friction) stays at `start` when it sees no more than the cube of that half side about
// `centre`: there it is a point so much smaller, and lifts itself over so much lower steps, than in the whole mesh. A proxy that the whole
// reference leaves over a step that holds a point is told from one that nothing holds. The cube's sides hold nothing. RT: no.
bool rests_in_close_up(const TriangleMesh& mesh, const Material& material, const Vec3& centre, double half_side, const Vec3& start,
                       const Vec3& device);

}  // namespace hapton
