#pragma once

#include <cstdint>

#include "core/geometry/triangle_plane.h"

namespace hapton {

// The line segment that the probe swept between two samples. Units: metres. Frame: the triangles'.
struct SweepLine {
  Vec3 last = Vec3::Zero();
  Vec3 current = Vec3::Zero();
};

// How far the test of one triangle got (steps of the memo's figure 3).
enum class SweepOutcome : std::uint8_t {
  parallel,         // step 2: the line is parallel to the plane, or in it
  out_of_length,    // step 3: it meets the plane before its start or beyond its end
  out_of_triangle,  // step 4: it meets the plane outside the triangle
  collision         // step 5: a valid collision point
};

// The collision of a sweep line with a triangle.
struct SweepCollision {
  double t = 0.0;              // along the line: 0 at last, 1 at current
  Vec3 point = Vec3::Zero();   // the collision point
  Vec3 normal = Vec3::Zero();  // unit, towards the side that the line comes from
  double depth = 0.0;          // how far `current` is below the plane, along the normal; >= 0
  bool from_behind = false;    // the line comes from the side that the triangle's own normal points away from
};

// Tests one triangle, steps 2 to 4. A point with height >= 0 is above the plane, any other below; a line collides only if its ends are on
// different sides. So where a path crosses the plane at the common end of two lines, exactly one of them collides. Post: collision is
// written only if the result is SweepOutcome::collision. RT: yes. Source: memo 4.2.2.
SweepOutcome compute_collision(const SweepLine& line, const TrianglePlane& plane, SweepCollision& collision) noexcept;

}  // namespace hapton
