#include "core/tool/feature_pair.h"

#include <algorithm>
#include <cmath>

#include "core/math/cross_matrix.h"

namespace hapton {
namespace {

using Kind = FeaturePair::Kind;

struct SegmentPoints {
  Vec3 on_a;
  Vec3 on_b;
  bool is_inside = false;
};

// The closest points of segments from a along d and from b along e (Ericson, Real-Time Collision Detection, 5.1.9). Each
// parameter is solved again at the end, with the other one fixed, so each point is within rounding the closest to the other point.
SegmentPoints closest_on_segments(const Vec3& a, const Vec3& d, const Vec3& b, const Vec3& e) {
  const Vec3 r = a - b;
  const double dd = d.squaredNorm();
  const double ee = e.squaredNorm();
  const double de = d.dot(e);
  const double dr = d.dot(r);
  const double er = e.dot(r);
  const double gram = dd * ee - de * de;
  const auto clamp01 = [](double x) { return std::clamp(x, 0.0, 1.0); };
  double s = gram > 0.0 ? clamp01((de * er - dr * ee) / gram) : 0.0;
  double t = ee > 0.0 ? clamp01((de * s + er) / ee) : 0.0;
  s = dd > 0.0 ? clamp01((de * t - dr) / dd) : 0.0;
  t = ee > 0.0 ? clamp01((de * s + er) / ee) : 0.0;
  return {a + s * d, b + t * e, s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0};
}

FeatureGap gap_between(const Vec3& on_tool, const Vec3& on_scene, const Vec3& position, TriangleFeature feature) {
  FeatureGap gap;
  const Vec3 between = on_tool - on_scene;
  gap.distance = between.norm();
  if (gap.distance > 0.0) gap.normal = between / gap.distance;
  gap.on_tool = on_tool - position;
  gap.on_scene = on_scene;
  gap.feature = feature;
  return gap;
}

// The second derivative of n . R(w) a with respect to the rotation vector w, at w = 0: the part of n . (e_i x (e_j x a)) that
// is symmetric in i and j.
Mat3 turn_curvature(const Vec3& n, const Vec3& a) { return 0.5 * (n * a.transpose() + a * n.transpose()) - n.dot(a) * Mat3::Identity(); }

// For two edges whose closest points are inside both: second derivative of f = N . u / |N|. N = d x e turns with the tool's edge d, and u
// leads from the scene's edge to the tool's.
Mat6 edge_curvature(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement) {
  const Vec3 d = placement.orientation * (pair.tool[1] - pair.tool[0]);
  const Vec3 e = pair.scene[1] - pair.scene[0];
  Vec3 unit = d.cross(e);
  const double length = unit.norm();
  if (!(length > 0x1p-48 * d.norm() * e.norm())) return Mat6::Zero();  // parallel within rounding
  unit /= unit.dot(gap.normal) < 0.0 ? -length : length;
  const double side = unit.dot(d.cross(e)) < 0.0 ? -1.0 : 1.0;
  // Divided by |N|: the derivatives of N with respect to the turn, in columns, ...
  const Mat3 normal = side / length * (cross_matrix(e) * cross_matrix(d));
  const auto by_second = [&](const Vec3& v) { return Mat3(side / length * turn_curvature(e.cross(v), d)); };  // ... and v . N''
  const Vec3 u = gap.distance * gap.normal;
  const Vec3& a = gap.on_tool;
  const Mat3 point = -cross_matrix(a);  // derivatives of u with respect to the turn, in columns
  const Vec3 first = normal.transpose() * u + point.transpose() * unit;
  const Mat3 crossed = normal.transpose() * point;
  const Vec3 length_slope = normal.transpose() * unit;  // derivative of |N| with respect to the turn, divided by |N|
  const Mat3 length_curvature = normal.transpose() * normal + by_second(unit) - length_slope * length_slope.transpose();
  const Mat3 second = by_second(u) + crossed + crossed.transpose() + turn_curvature(unit, a);
  const double value = unit.dot(u);
  const Mat3 mixed = first * length_slope.transpose();
  Mat6 curvature = Mat6::Zero();
  curvature.bottomRightCorner<3, 3>() =
      second - (mixed + mixed.transpose()) - value * (length_curvature - 2.0 * length_slope * length_slope.transpose());
  curvature.bottomLeftCorner<3, 3>() = normal.transpose() - length_slope * unit.transpose();
  curvature.topRightCorner<3, 3>() = curvature.bottomLeftCorner<3, 3>().transpose();
  return curvature;
}

}  // namespace

FeatureGap measure_gap(const FeaturePair& pair, const Placement& placement) noexcept {
  switch (pair.kind) {
    case Kind::vertex_face: {
      const Vec3 p = placement.at(pair.tool[0]);
      const ClosestPoint near = closest_point(pair.scene[0], pair.scene[1], pair.scene[2], p);
      return gap_between(p, near.point, placement.position, near.feature);
    }
    case Kind::face_vertex: {
      const ClosestPoint near =
          closest_point(placement.at(pair.tool[0]), placement.at(pair.tool[1]), placement.at(pair.tool[2]), pair.scene[0]);
      return gap_between(near.point, pair.scene[0], placement.position, near.feature);
    }
    case Kind::edge_edge:
      break;
  }
  const Vec3 a = placement.at(pair.tool[0]);
  const SegmentPoints near =
      closest_on_segments(a, placement.orientation * (pair.tool[1] - pair.tool[0]), pair.scene[0], pair.scene[1] - pair.scene[0]);
  return gap_between(near.on_a, near.on_b, placement.position, near.is_inside ? TriangleFeature::face : TriangleFeature::vertex0);
}

double gap_along(const FeaturePair& pair, const FeatureGap& gap, const Placement& from, const Placement& to) noexcept {
  const Quat turn = to.orientation * from.orientation.conjugate();
  const Vec3 between = to.position + turn * gap.on_tool - gap.on_scene;
  if (pair.kind == Kind::face_vertex && gap.feature == TriangleFeature::face) return (turn * gap.normal).dot(between);
  if (pair.kind == Kind::edge_edge && gap.feature == TriangleFeature::face) {
    const Vec3 d = to.orientation * (pair.tool[1] - pair.tool[0]);
    const Vec3 e = pair.scene[1] - pair.scene[0];
    const Vec3 normal = d.cross(e);
    const double length = normal.norm();
    const double cosine = normal.dot(gap.normal);
    // The normal has turned by less than 60 degrees. Otherwise the gap along the old normal is returned.
    if (std::fabs(cosine) > 0.5 * length) return normal.dot(between) / (cosine < 0.0 ? -length : length);
  }
  return gap.normal.dot(between);
}

Mat6 gap_curvature(const FeaturePair& pair, const FeatureGap& gap, const Placement& placement) noexcept {
  const bool is_inside = gap.feature == TriangleFeature::face;
  if (pair.kind == Kind::edge_edge && is_inside) return edge_curvature(pair, gap, placement);
  Mat6 curvature = Mat6::Zero();
  if (pair.kind == Kind::face_vertex && is_inside) {
    // In the frame of the face, the vertex moves: n . R(-w) (position + shift - vertex).
    curvature.bottomRightCorner<3, 3>() = turn_curvature(gap.normal, placement.position - gap.on_scene);
    curvature.bottomLeftCorner<3, 3>() = cross_matrix(gap.normal);
    curvature.topRightCorner<3, 3>() = curvature.bottomLeftCorner<3, 3>().transpose();
  } else {
    curvature.bottomRightCorner<3, 3>() = turn_curvature(gap.normal, gap.on_tool);
  }
  return curvature;
}

}  // namespace hapton
