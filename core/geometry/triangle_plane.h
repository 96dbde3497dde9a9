#pragma once

#include <array>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// The numbers precalculated for one static triangle, so that a crossing of its plane is soon found inside or outside of it:
// the plane, and the triangle's shadow along the dominant axis of the normal for the Jordan curve test (a ray from the point
// crosses the outline an odd number of times when the point is inside).
// Units: metres. Frame: the corners'; the shadow is relative to corner 0, so that a scene far from the origin loses nothing.
// Source: memo 4.2.2, second step of the precalculation; crossings test as in Graphics Gems (memo reference 7). We differ in the
// outline: it belongs to the triangle, to within the rounding of the point tested, so that no line slips between two neighbours.
// RT: yes.
struct TrianglePlane {
  // One side of the shadow, lower end first, so that neighbours see the same numbers.
  struct Side {
    double low_u, low_v, high_v;  // lower end, and how high it goes: half-open [low_v, high_v)
    double slope;                 // du/dv; unused where high_v == low_v
    double inward_u, inward_v;    // unit vector across the side, into the triangle
  };

  Vec3 origin;         // corner 0
  Vec3 normal;         // unit; the corners turn counter-clockwise seen from its head
  double reach;        // largest coordinate of the corners from the origin
  int u_axis, v_axis;  // the two axes of the shadow
  std::array<Side, 3> sides;

  // Signed distance of p above the plane.
  double height_of(const Vec3& p) const noexcept { return normal.dot(p - origin); }

  // Whether the shadow holds the point (u, v), which is given relative to the origin. A point that the crossings put outside still
  // counts as inside when it is no farther out than it is uncertain: slack in any direction, plus along_u, along_v either way.
  bool contains(double u, double v, double slack, double along_u, double along_v) const noexcept;
};

// The numbers of triangle abc; none when it is degenerate: thinner than the rounding of its own corners, so that it has no plane.
// RT: yes.
std::optional<TrianglePlane> compute_triangle_plane(const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

}  // namespace hapton
