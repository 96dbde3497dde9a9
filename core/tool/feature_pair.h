#pragma once

#include <array>
#include <cstdint>

#include "core/geometry/closest_point.h"
#include "core/tool/placement.h"

namespace hapton {

// Two features of tool and scene that can touch: a vertex of one and a triangle of the other, or an edge of each. While the distance of
// every such pair is above zero, the surfaces do not intersect.
struct FeaturePair {
  enum class Kind : std::uint8_t { vertex_face, face_vertex, edge_edge };  // the tool's feature is named first

  Kind kind = Kind::vertex_face;
  std::uint32_t tool_triangle = 0;
  std::uint32_t scene_triangle = 0;  // TouchGeometry's number
  int tool_corner = 0;               // of the vertex, or the edge, in its triangle; unused for a face
  int scene_corner = 0;
  std::array<Vec3, 3> tool;   // from the grip point, tool axes: 1, 3 or 2 points
  std::array<Vec3, 3> scene;  // 3, 1 or 2 points
};

// The distance of a pair at one placement. Frame: the scene's local one.
struct FeatureGap {
  double distance = 0.0;
  Vec3 normal = Vec3::Zero();    // unit, from the scene to the tool; zero at distance zero
  Vec3 on_tool = Vec3::Zero();   // closest point, from the grip point
  Vec3 on_scene = Vec3::Zero();  // closest point
  // The feature of the triangle that is closest. edge_edge: `face` if the points lie inside both edges, `vertex0` if one is an end.
  TriangleFeature feature = TriangleFeature::face;
};

// The closest points. RT: yes.
FeatureGap measure_gap(const FeaturePair& pair, const Placement& placement) noexcept;

// The distance at `to` along the closest features of `from`: a face's normal turns with the face, an edge pair's with both edges. Accurate
// to second order of the motion between the two, where the distance itself may meanwhile be attained elsewhere. RT: yes.
double gap_along(const FeaturePair& pair, const FeatureGap& gap, const Placement& from, const Placement& to) noexcept;

// The second derivative of gap_along at no motion, by the shift and the turn (a rotation vector), in this order. Edges that are parallel to
// rounding: zero. RT: yes. Pre: gap is the pair's at the placement.
Mat6 gap_curvature(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement) noexcept;

}  // namespace hapton
