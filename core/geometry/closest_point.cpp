#include "core/geometry/closest_point.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

bool lexicographically_less(const Vec3& a, const Vec3& b) {
  if (a.x() != b.x()) return a.x() < b.x();
  if (a.y() != b.y()) return a.y() < b.y();
  return a.z() < b.z();
}

struct SegmentPoint {
  Vec3 point;
  Vec3 offset;  // query minus point
  double t;     // 0 at a, 1 at b
};

// The caller orders a and b canonically, so that both triangles at an edge get the same result, to the bit.
SegmentPoint closest_on_ordered_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 e = b - a;
  const Vec3 w = p - a;
  const double length2 = e.squaredNorm();
  const double along = w.dot(e);
  if (!(along > 0.0) || length2 == 0.0) return {a, w, 0.0};
  if (along >= length2) return {b, p - b, 1.0};
  double t = along / length2;
  Vec3 offset = w - t * e;
  // A second pass: the first leaves rounding along e, which would tilt the direction of a tiny offset.
  const double correction = offset.dot(e) / length2;
  offset -= correction * e;
  t = std::clamp(t + correction, 0.0, 1.0);
  return {a + t * e, offset, t};
}

SegmentPoint closest_on_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  if (!lexicographically_less(b, a)) return closest_on_ordered_segment(a, b, p);
  SegmentPoint found = closest_on_ordered_segment(b, a, p);
  found.t = 1.0 - found.t;
  return found;
}

bool projects_inside(const PreparedTriangle& triangle, const Vec3& p) {
  for (int k = 0; k < 3; ++k) {
    if (triangle.inward[k].dot(p - triangle.corner[k]) < 0.0) return false;
  }
  return true;
}

ClosestPoint closest_on_face(const PreparedTriangle& triangle, const Vec3& p) {
  ClosestPoint found;
  found.feature = TriangleFeature::face;
  const double height = triangle.normal.dot(p - triangle.corner[triangle.base]);
  found.distance = std::abs(height);
  found.direction = height < 0.0 ? Vec3(-triangle.normal) : triangle.normal;
  found.point = p - height * triangle.normal;
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    const int opposite = (k + 2) % 3;
    found.barycentric[opposite] = std::max(0.0, triangle.inward[k].dot(p - triangle.corner[k]));
    sum += found.barycentric[opposite];
  }
  if (sum > 0.0) {
    found.barycentric /= sum;
  } else {
    found.barycentric = Vec3::Constant(1.0 / 3.0);
  }
  return found;
}

ClosestPoint closest_on_boundary(const PreparedTriangle& triangle, const Vec3& p) {
  int best_edge = 0;
  SegmentPoint nearest = closest_on_segment(triangle.corner[0], triangle.corner[1], p);
  double best_distance2 = nearest.offset.squaredNorm();
  for (int k = 1; k < 3; ++k) {
    const SegmentPoint candidate = closest_on_segment(triangle.corner[k], triangle.corner[(k + 1) % 3], p);
    const double candidate_distance2 = candidate.offset.squaredNorm();
    if (candidate_distance2 < best_distance2) {
      best_edge = k;
      best_distance2 = candidate_distance2;
      nearest = candidate;
    }
  }
  ClosestPoint found;
  found.point = nearest.point;
  found.distance = nearest.offset.norm();
  if (found.distance > 0.0) found.direction = nearest.offset / found.distance;
  found.barycentric[best_edge] = 1.0 - nearest.t;
  found.barycentric[(best_edge + 1) % 3] = nearest.t;
  if (nearest.t <= 0.0) {
    found.feature = vertex_feature(best_edge);
  } else if (nearest.t >= 1.0) {
    found.feature = vertex_feature((best_edge + 1) % 3);
  } else {
    found.feature = edge_feature(best_edge);
  }
  return found;
}

}  // namespace

PreparedTriangle::PreparedTriangle(const Vec3& a, const Vec3& b, const Vec3& c) : corner{a, b, c} {
  std::array<double, 3> length2;
  for (int k = 0; k < 3; ++k) {
    edge[k] = corner[(k + 1) % 3] - corner[k];
    length2[k] = edge[k].squaredNorm();
  }
  base = static_cast<int>(std::max_element(length2.begin(), length2.end()) - length2.begin());
  const int next = (base + 1) % 3;
  const int before = (base + 2) % 3;
  // The cross product of the longest and the shortest edge loses the fewest digits. Its error along the longest edge is removed again, so
  // what remains is a rotation about that edge, which moves the triangle by no more than its own height times the angle.
  const Vec3 raw = length2[next] < length2[before] ? edge[base].cross(edge[next]) : edge[before].cross(edge[base]);
  const double raw_length = raw.norm();
  if (raw_length > 0.0 && length2[base] > 0.0) {
    const Vec3 axis = edge[base] / std::sqrt(length2[base]);
    Vec3 n = raw / raw_length;
    n -= n.dot(axis) * axis;
    n -= n.dot(axis) * axis;
    const double n_length = n.norm();
    if (n_length > 0.5) {
      normal = n / n_length;
      has_face = true;
    }
  }
  for (int k = 0; k < 3; ++k) inward[k] = normal.cross(edge[k]);
}

ClosestPoint closest_point(const PreparedTriangle& triangle, const Vec3& p) {
  if (triangle.has_face && projects_inside(triangle, p)) return closest_on_face(triangle, p);
  return closest_on_boundary(triangle, p);
}

}  // namespace hapton
