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
  std::uint32_t scene_triangle = 0;  // as TouchGeometry numbers it
  int tool_corner = 0;               // number of the vertex or edge in its triangle; unused for a face
  int scene_corner = 0;
  std::array<Vec3, 3> tool;   // from the grip point, tool axes: 1, 3 or 2 points, by kind
  std::array<Vec3, 3> scene;  // the scene's local frame: 3, 1 or 2 points
};

// The distance of a pair at one placement. Frame: the scene's local one.
struct FeatureGap {
  double distance = 0.0;
  Vec3 normal = Vec3::Zero();    // unit, from the scene to the tool; zero at distance zero
  Vec3 on_tool = Vec3::Zero();   // closest point on the tool, from the grip point along the scene's axes
  Vec3 on_scene = Vec3::Zero();  // closest point on the scene
  // The feature of the triangle on which its closest point lies. edge_edge: `face` if both points lie inside their edges, else `vertex0`.
  TriangleFeature feature = TriangleFeature::face;
};

// Finds the closest points of a pair. RT: yes.
FeatureGap measure_gap(const FeaturePair& pair, const Placement& placement) noexcept;

// The distance at `to` along the normal of the closest features at `from`: the normal of a face turns with the face, that of an edge pair
// with the edges. Accurate to second order in the motion; at `to` other features of the pair may be closest instead. RT: yes.
double gap_along(const FeaturePair& pair, const FeatureGap& gap, const Placement& from, const Placement& to) noexcept;

// The second derivative of gap_along at zero motion, with respect to the shift, then the turn (a rotation vector). Zero for edges that are
// parallel within rounding. RT: yes. Pre: gap is that of the pair at this placement.
Mat6 gap_curvature(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement) noexcept;

}  // namespace hapton
