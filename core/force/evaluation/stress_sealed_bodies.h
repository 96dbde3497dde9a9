#pragma once

#include "core/force/evaluation/stress_body.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Bodies with cracks and T-junctions, sealed as a mesh is when it is loaded for touch. The sealed mesh defines the solid; a body that is
// not closed after sealing has none. About 0.1 m long. width_share: width of the widest gap as a share of the extent. RT: no.

// Cracks at every edge: a sphere, and a star with sharp spikes.
StressBody make_sealed_tears(double width_share);
StressBody make_sealed_star(double width_share);
// Faces with different tessellations, flat: a box.
StressBody make_sealed_box(double width_share);
// Patches with different tessellations, curved: a sphere and a wavy one; the two sides of a seam follow different chords.
StressBody make_sealed_ball(double width_share);
StressBody make_sealed_waves(double width_share);

}  // namespace hapton
