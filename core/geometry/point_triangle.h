#pragma once

#include <cmath>
#include <cstdint>

#include "core/math/exact_cross.h"
#include "core/math/types.h"

namespace hapton {

// Which part of a triangle is nearest.
enum class Feature : std::uint8_t { face, edge, vertex };

// How a point stands to a triangle.
struct Separation {
  double distance = 0.0;         // >= 0
  Vec3 normal = Vec3::Zero();    // unit, from the nearest point to the query point: the gradient of the distance
  Vec3 nearest = Vec3::Zero();   // on the triangle
  Vec3 along = Vec3::Zero();     // edge feature: the edge's direction (any length); else zero
  Feature feature = Feature::face;
};

namespace detail {

struct NearestOnEdge {
  double distance_squared;
  Vec3 nearest;
  bool inner;  // not an end
};

inline NearestOnEdge nearest_on_edge(const Vec3& p, const Vec3& a, const Vec3& edge) {
  const double length_squared = edge.squaredNorm();
  const Vec3 ap = p - a;
  const double dot = ap.dot(edge);
  const double t = length_squared > 0.0 ? std::fmin(1.0, std::fmax(0.0, dot / length_squared)) : 0.0;
  const Vec3 off = ap - t * edge;
  return {off.squaredNorm(), a + t * edge, t > 0.0 && t < 1.0};
}

}  // namespace detail

// The distance from p to triangle abc with its gradient, correct for needles and zero-area triangles too: the face decides only
// where the point projects strictly inside all three edges, otherwise the nearest of the three edges does.
// A point exactly on the triangle gets the side its vertex order shows (or, without area, an arbitrary normal).
// Frames: any, one for all. Pre: edges exact for slivers (see TouchGeometry). RT: yes.
inline Separation separation_from_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a;
  const Vec3 bc = c - b;
  const Vec3 ca = a - c;
  const Vec3 normal = accurate_cross(ab, -ca);
  const double normal_squared = normal.squaredNorm();
  if (normal_squared > 0.0) {
    const Vec3 ap = p - a;
    const bool inside = normal.cross(ab).dot(ap) > 0.0 && normal.cross(bc).dot(p - b) > 0.0 && normal.cross(ca).dot(p - c) > 0.0;
    if (inside) {
      const double inverse_length = 1.0 / std::sqrt(normal_squared);
      const double height = normal.dot(ap) * inverse_length;
      const Vec3 unit = normal * (height < 0.0 ? -inverse_length : inverse_length);
      const double distance = std::fabs(height);
      return {distance, unit, p - distance * unit, Vec3::Zero(), Feature::face};
    }
  }
  detail::NearestOnEdge best = detail::nearest_on_edge(p, a, ab);
  Vec3 along = ab;
  const detail::NearestOnEdge on_bc = detail::nearest_on_edge(p, b, bc);
  if (on_bc.distance_squared < best.distance_squared) {
    best = on_bc;
    along = bc;
  }
  const detail::NearestOnEdge on_ca = detail::nearest_on_edge(p, c, ca);
  if (on_ca.distance_squared < best.distance_squared) {
    best = on_ca;
    along = ca;
  }
  Separation result;
  result.distance = std::sqrt(best.distance_squared);
  result.nearest = best.nearest;
  result.feature = best.inner ? Feature::edge : Feature::vertex;
  if (best.inner) result.along = along;
  if (result.distance > 0.0) {
    result.normal = (p - best.nearest) / result.distance;
  } else {
    result.normal = normal_squared > 0.0 ? Vec3(normal / std::sqrt(normal_squared)) : along.squaredNorm() > 0.0 ? along.unitOrthogonal() : Vec3::UnitX();
  }
  return result;
}

}  // namespace hapton
