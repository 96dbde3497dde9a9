#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/math/exact_cross.h"
#include "core/math/types.h"

namespace hapton {

// The closest feature of a triangle.
enum class Feature : std::uint8_t { face, edge, vertex };

// The position of a point relative to a triangle.
struct Separation {
  double distance = 0.0;        // >= 0
  Vec3 normal = Vec3::Zero();   // unit, from the nearest point to the query point: the gradient of the distance
  Vec3 nearest = Vec3::Zero();  // on the triangle
  Feature feature = Feature::face;
};

// How far the computed normal may deviate from the true one (rad); s is in TouchGeometry's local units. The normal of a face is computed
// from exact edges. That of an edge or a vertex is as exact, but rounding may choose the edge where the face is nearer by a rounding error,
// and then the normal deviates by that error over the distance.
inline double normal_error(const Separation& s) {
  constexpr double kFaceError = 0x1p-48;
  constexpr double kPositionError = 0x1p-50;
  return s.feature == Feature::face ? kFaceError : s.distance > kPositionError ? kPositionError / s.distance : 1.0;
}

namespace detail {

// A share of squared lengths: a vector shorter than 2^-20 of the edge has lost too many digits of its direction.
constexpr double kShortSquaredShare = 0x1p-40;

// Removes from `off`, a vector from the edge to a point, the component along the edge: it is rounding of the closest point.
inline Vec3 perpendicular_to(const Vec3& edge, double inverse_squared, const Vec3& off) {
  return off - (off.dot(edge) * inverse_squared) * edge;
}

struct NearestOnEdge {
  double distance_squared;
  Vec3 off;  // from the closest point to p
  Vec3 nearest;
  bool is_inner;  // nearest is not an end of the edge
};

inline NearestOnEdge nearest_on_edge(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 edge = b - a;
  const double length_squared = edge.squaredNorm();
  const double dot = (p - a).dot(edge);
  if (!(dot > 0.0)) return {(p - a).squaredNorm(), p - a, a, false};
  if (!(dot < length_squared)) return {(p - b).squaredNorm(), p - b, b, false};
  const double t = dot / length_squared;
  Vec3 off = (p - a) - t * edge;
  if (off.squaredNorm() < kShortSquaredShare * length_squared) off = perpendicular_to(edge, 1.0 / length_squared, off);
  return {off.squaredNorm(), off, a + t * edge, true};
}

}  // namespace detail

// The distance from p to triangle abc with its gradient, correct for needles and triangles without area, too: the face decides only if the
// projection of p is strictly inside all three edges, otherwise the closest of those edges that have p on their outer side (one of them
// contains the closest point, because the triangle is convex). A point exactly on the triangle gets the normal given by the order of the
// vertices (without area, an arbitrary one). Frames: any, one for all. Pre: edges are exact for slivers (see TouchGeometry). RT: yes.
inline Separation separation_from_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 bc = c - b;
  const Vec3 ca = a - c;
  const Vec3 ap = p - a;
  const Vec3 normal = accurate_cross(ab, -ca);
  const double normal_squared = normal.squaredNorm();
  const Vec3 turned = ap.cross(normal);  // its dot product with an edge that starts or ends at a: > 0 on the inner side
  const bool outside_ab = !(turned.dot(ab) > 0.0);
  const bool outside_bc = !((p - b).cross(normal).dot(bc) > 0.0);
  const bool outside_ca = !(turned.dot(ca) > 0.0);
  if (!outside_ab && !outside_bc && !outside_ca) {
    const double inverse_length = 1.0 / std::sqrt(normal_squared);
    const double height = normal.dot(ap) * inverse_length;
    const Vec3 unit = normal * (height < 0.0 ? -inverse_length : inverse_length);
    const double distance = std::fabs(height);
    return {distance, unit, p - distance * unit, Feature::face};
  }
  detail::NearestOnEdge best{std::numeric_limits<double>::infinity(), Vec3::Zero(), Vec3::Zero(), false};
  Vec3 along = ab;
  const auto consider = [&](const Vec3& from, const Vec3& to) {
    const detail::NearestOnEdge on_edge = detail::nearest_on_edge(p, from, to);
    if (!(on_edge.distance_squared < best.distance_squared)) return;
    best = on_edge;
    along = to - from;
  };
  if (outside_ab) consider(a, b);
  if (outside_bc) consider(b, c);
  if (outside_ca) consider(c, a);
  Separation result;
  result.distance = std::sqrt(best.distance_squared);
  result.nearest = best.nearest;
  result.feature = best.is_inner ? Feature::edge : Feature::vertex;
  if (result.distance > 0.0) {
    result.normal = best.off / result.distance;  // unit even if p - nearest is mostly rounding
  } else if (normal_squared > 0.0) {
    result.normal = normal / std::sqrt(normal_squared);
  } else {
    result.normal = along.squaredNorm() > 0.0 ? along.unitOrthogonal() : Vec3::UnitX();
  }
  return result;
}

}  // namespace hapton
