#pragma once

#include <cstdint>

#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Generated meshes with cracks and T-junctions, as in scans and CAD exports. Pure functions of their arguments. Units: metres. width: no
// gap, measured from a vertex to the other side of the crack, is wider. Pre: width is small compared with every triangle. RT: set-up only.

// Each triangle has its own vertices, moved towards the triangle's middle by half the width: every edge is an open crack.
TriangleMesh make_torn(const TriangleMesh& mesh, double width);

// Each triangle has its own vertices, moved by up to half the width at random: cracks that gape and overlap.
TriangleMesh make_shaken(const TriangleMesh& mesh, double width, std::uint64_t seed);

// A box about the origin whose six faces are separate sheets with different numbers of squares. Vertices along their rims are moved by
// up to half the width at random: T-junctions and cracks along all twelve right-angled edges.
TriangleMesh make_patched_box(const Vec3& size_m, double width, std::uint64_t seed);

// A sphere about the origin, its radius modulated by waves of the given relative height, in seven patches: three above the equator, four
// below. Vertices along all seams are moved by up to a quarter of the width at random. The equator is divided differently on its two sides:
// T-junctions, and gaps between chords that differ. Meridian seams have the same vertices on both sides before these are moved: cracks.
TriangleMesh make_patched_sphere(double radius_m, double relative_height, double width, std::uint64_t seed);

}  // namespace hapton
