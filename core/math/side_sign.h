#pragma once

#include "core/math/exact_cross.h"
#include "core/math/orient3d.h"
#include "core/math/types.h"

namespace hapton {

// Exact signs for points that move among triangles. Zero or undetermined only for a triangle without area, an edge or segment without
// length, and a segment parallel to the edge that it passes, which crosses no triangle at that edge. Where the given points lie exactly in
// a plane, or on a line through an edge, all moving points are treated as shifted in one common direction by an infinitesimal amount
// (Edelsbrunner & Muecke 1990, simulation of simplicity; we shift only the moving points, all alike). So a chain of segments crosses a
// closed surface like one in general position: it never passes through an edge without a crossing, and where one segment ends, and the next
// begins, at a point of the surface, only one of them crosses it. Pre: see orient3d. RT: yes.

// The direction of the shift, chosen so that no symmetry of a mesh is aligned with it: powers of the reciprocal of a root of x^4 = x + 1,
// with mixed signs.
inline const Vec3 kShift(0.8191725133961645, -0.6710436067037893, 0.5497004779019703);

// > 0 if the moving point p is on the side of abc from which a, b, c are seen in counter-clockwise order.
inline double side_sign(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) noexcept {
  const double sign = orient3d_sign(a, b, c, p);
  return sign != 0.0 ? sign : accurate_cross(b - a, c - a).dot(kShift);
}

// The sign of det(q - p, a - p, b - p): on which side the segment of a moving point from p to q passes the line through a and b.
inline double pass_sign(const Vec3& p, const Vec3& q, const Vec3& a, const Vec3& b) noexcept {
  const double sign = orient3d_sign(p, q, a, b);
  return sign != 0.0 ? sign : -(q - p).dot(kShift.cross(b - a));
}

}  // namespace hapton
