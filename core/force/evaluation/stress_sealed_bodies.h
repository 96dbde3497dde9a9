#pragma once

#include "core/force/evaluation/stress_body.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Bodies with cracks and T-junctions, sealed as a mesh is that is loaded for touch; each is its own judge, so one that does not become
// closed is none. About 0.1 m long. width_share: of the widest gap, as a share of the extent.

// Triangles torn apart at every edge: a sphere, and a star with sharp spikes.
StressBody make_sealed_tears(double width_share);
StressBody make_sealed_star(double width_share);
// Faces tessellated apart, flat: a box.
StressBody make_sealed_box(double width_share);
// Patches tessellated apart, curved: a sphere and a wavy one, their sides following the seams by different chords.
StressBody make_sealed_ball(double width_share);
StressBody make_sealed_waves(double width_share);

}  // namespace hapton
