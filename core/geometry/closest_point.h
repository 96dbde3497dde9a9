#pragma once

#include <array>
#include <cstdint>

#include "core/math/types.h"

namespace hapton {

// The feature of a triangle that is closest to a point. Edge k runs from corner k to corner (k + 1) mod 3.
enum class TriangleFeature : std::uint8_t { face, edge0, edge1, edge2, vertex0, vertex1, vertex2 };

inline bool is_edge(TriangleFeature feature) { return feature >= TriangleFeature::edge0 && feature <= TriangleFeature::edge2; }
inline bool is_vertex(TriangleFeature feature) { return feature >= TriangleFeature::vertex0; }
inline TriangleFeature edge_feature(int k) { return static_cast<TriangleFeature>(static_cast<int>(TriangleFeature::edge0) + k); }
inline TriangleFeature vertex_feature(int k) { return static_cast<TriangleFeature>(static_cast<int>(TriangleFeature::vertex0) + k); }
inline int edge_number(TriangleFeature edge) { return static_cast<int>(edge) - static_cast<int>(TriangleFeature::edge0); }
inline int vertex_number(TriangleFeature vertex) { return static_cast<int>(vertex) - static_cast<int>(TriangleFeature::vertex0); }

// A triangle prepared for distance queries: corners, unit normal and inward edge directions. Any triangle is allowed: needles, caps, zero
// area, three equal corners. A triangle of exactly zero area has no face, only its edges. Pre: finite corners; the squared lengths of edges
// that are not zero neither overflow nor underflow. RT: yes.
struct PreparedTriangle {
  PreparedTriangle() = default;
  PreparedTriangle(const Vec3& a, const Vec3& b, const Vec3& c);

  std::array<Vec3, 3> corner;
  std::array<Vec3, 3> edge;    // from corner k to corner (k + 1) mod 3
  std::array<Vec3, 3> inward;  // normal x edge: in the plane, away from edge k into the triangle
  Vec3 normal = Vec3::Zero();  // unit, counter-clockwise side; zero if has_face is false
  int base = 0;                // number of the longest edge: the normal is most exact about it, so heights are measured from its corner
  bool has_face = false;
};

// The closest point of a triangle to a query point.
struct ClosestPoint {
  Vec3 point = Vec3::Zero();        // on the triangle
  Vec3 direction = Vec3::Zero();    // unit, from the triangle to the query point; on a face its normal, signed; zero if undefined
  Vec3 barycentric = Vec3::Zero();  // weights of the corners, each in [0, 1], sum 1
  double distance = 0.0;
  TriangleFeature feature = TriangleFeature::vertex0;
};

// The point of the triangle closest to p, to a few roundings of the larger of |p - corner| and the longest edge, whatever the triangle's
// shape. An edge or a corner shared by two triangles gives bit-equal results from both. A distance of zero on an edge or a corner has no
// direction. RT: yes. Source: the region tests of Ericson, Real-Time Collision Detection (2005), 5.1.5; we differ in a well-conditioned
// formula for each region instead of one set of barycentric products, which lose all digits on needles.
ClosestPoint closest_point(const PreparedTriangle& triangle, const Vec3& p);

inline ClosestPoint closest_point(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& p) {
  return closest_point(PreparedTriangle(a, b, c), p);
}

}  // namespace hapton
