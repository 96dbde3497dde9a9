#pragma once

#include <array>
#include <optional>

#include "core/math/types.h"

namespace hapton {

// Precomputed data of one static triangle, for a fast test whether a point of its plane is inside: the plane, and the triangle's projection
// along the dominant axis of the normal for the Jordan curve test (a ray from an inside point crosses the outline an odd number of times).
// Units: metres. Frame: the corners'; the projection is relative to corner 0, so a scene far from the origin loses no digits.
// Source: memo 4.2.2, second step of the precalculation; crossings test as in Graphics Gems (memo reference 7). We differ in the outline:
// it belongs to the triangle, to within the rounding of the point tested, so that no line passes between two neighbours.
// RT: yes.
struct TrianglePlane {
  // One side of the projection, lower end first, so that neighbours have the same numbers.
  struct Side {
    double low_u, low_v, high_v;  // lower end, and upper limit: half-open [low_v, high_v)
    double slope;                 // du/dv; unused where high_v == low_v
    double inward_u, inward_v;    // unit vector perpendicular to the side, into the triangle
  };

  Vec3 origin;         // corner 0
  Vec3 normal;         // unit; the corners run counter-clockwise around it
  double extent;       // largest absolute coordinate of the corners relative to the origin
  int u_axis, v_axis;  // the two axes of the projection
  std::array<Side, 3> sides;

  // Signed distance of p above the plane.
  double height_of(const Vec3& p) const noexcept { return normal.dot(p - origin); }

  // Whether the projection contains the point (u, v), given relative to the origin. A point that the crossings test finds outside still
  // counts as inside if it is within its uncertainty: `tolerance` in any direction, and (along_u, along_v) forwards or backwards.
  bool contains(double u, double v, double tolerance, double along_u, double along_v) const noexcept;
};

// The data of triangle abc; empty if the triangle has no plane: twice its area is at most 2^-50 of its extent squared. RT: yes.
std::optional<TrianglePlane> compute_triangle_plane(const Vec3& a, const Vec3& b, const Vec3& c) noexcept;

}  // namespace hapton
