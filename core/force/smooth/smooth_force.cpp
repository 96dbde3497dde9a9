#include "core/force/smooth/smooth_force.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/triangle_distance.h"

namespace hapton {
namespace {

// A triangle as seen from one side.
struct Sided {
  std::array<Vec3, 3> corner;
  std::array<Vec3, 3> normal;
  Vec3 face_normal;
};

Sided from_front(const SetTriangle& t) { return {t.corner, t.normal, t.face_normal}; }
Sided from_behind(const SetTriangle& t) {
  return {{t.corner[0], t.corner[2], t.corner[1]}, {-t.normal[0], -t.normal[2], -t.normal[1]}, -t.face_normal};
}

// For one edge, in the terms of the FDH paper: B is the edge's point nearest to P, R the plane through B that contains the edge and n.
struct EdgePlane {
  Vec3 n;    // normal at B, a unit vector
  double d;  // distance of P from R; d >= 0: P is on the triangle's side of R
};

// False if edge and normal span no plane, or if the two normals of a fan are equal.
bool make_edge_plane(const Vec3& a, const Vec3& b, const Vec3& na, const Vec3& nb, const Vec3& P, EdgePlane& plane) {
  const Vec3 e = b - a;
  Vec3 B;
  Vec3 m;
  if (e.isZero(0.0)) {
    // A degenerate triangle's edge of length zero: R is the plane in which the normal turns from na to nb. The direction in R that points
    // to P sets the normal, as B does for other edges, so both triangles at this R find the same normal.
    m = na.cross(nb);
    const double mm = m.squaredNorm();
    if (!(mm > 0.0)) return false;
    const Vec3 up = P - a;
    const double beta = na.cross(up).dot(m);  // up = alpha na + beta nb + along m
    const double alpha = up.cross(nb).dot(m);
    const double sum = alpha + beta;
    const double t = sum > 0.0 ? std::clamp(beta / sum, 0.0, 1.0) : 0.5;
    plane.n = (1.0 - t) * na + t * nb;
    B = a;
  } else {
    const double t = std::clamp((P - a).dot(e) / e.squaredNorm(), 0.0, 1.0);
    B = a + t * e;
    plane.n = (1.0 - t) * na + t * nb;
    m = plane.n.cross(e);
  }
  const double length = m.norm();
  const double n_length = plane.n.norm();
  if (!(length > 0.0) || !(n_length > 0.0)) return false;
  plane.n /= n_length;
  plane.d = (P - B).dot(m) / length;
  return true;
}

// n0 / d0 + n1 / d1 + n2 / d2 without division: on an edge that edge's normal decides, at a vertex those of both edges, which are equal.
Vec3 blend(const std::array<EdgePlane, 3>& plane) {
  const double d0 = std::fabs(plane[0].d);
  const double d1 = std::fabs(plane[1].d);
  const double d2 = std::fabs(plane[2].d);
  const double largest = std::max({d0, d1, d2});
  if (!(largest > 0.0)) return (plane[0].n + plane[1].n + plane[2].n).normalized();
  const double a = d0 / largest;
  const double b = d1 / largest;
  const double c = d2 / largest;
  Vec3 n = (b * c) * plane[0].n + (a * c) * plane[1].n + (a * b) * plane[2].n;
  const double length = n.norm();
  if (length > 0.0) return n / length;
  n.setZero();
  for (const EdgePlane& one : plane) {
    if (std::fabs(one.d) <= 1e-150 * largest || one.d == 0.0) n += one.n;
  }
  return n.normalized();
}

bool make_planes(const Sided& t, const Vec3& P, std::array<EdgePlane, 3>& plane) {
  for (int k = 0; k < 3; ++k) {
    const int j = (k + 1) % 3;
    if (!make_edge_plane(t.corner[k], t.corner[j], t.normal[k], t.normal[j], P, plane[k])) return false;
  }
  return true;
}

bool find_face_vcp(const Sided& t, const Vec3& P, double radius, SmoothVcp& vcp) {
  const double height = t.face_normal.dot(P - t.corner[0]);
  if (!(height > 0.0 && height < radius)) return false;
  if (!(triangle_distance_squared(P, t.corner[0], t.corner[1], t.corner[2]) < radius * radius)) return false;
  std::array<EdgePlane, 3> plane;
  if (!make_planes(t, P, plane)) return false;
  if (!(plane[0].d >= 0.0 && plane[1].d >= 0.0 && plane[2].d >= 0.0)) return false;
  const Vec3 n = blend(plane);
  const double slope = n.dot(t.face_normal);
  if (!(slope > 0.0)) return false;
  vcp.distance = height / slope;
  vcp.away = n;
  vcp.D = P - vcp.distance * n;
  vcp.sign = 1;
  return vcp.distance < radius;
}

// D is a point of the fan's segment, so |DP| is never less than the distance of P from this segment.
bool is_near_fan(const SetTriangle& t, const Vec3& P, double radius) {
  const Vec3& a = t.corner[0];
  const Vec3 e = (t.corner[1] == a ? t.corner[2] : t.corner[1]) - a;
  return detail::segment_distance_squared<double>(of3(P - a), of3(e)) < radius * radius;
}

bool find_fan_vcp(const Sided& t, SurfaceKind kind, const Vec3& P, double radius, SmoothVcp& vcp) {
  std::array<EdgePlane, 3> plane;
  if (!make_planes(t, P, plane)) return false;
  const bool is_inside_all = plane[0].d >= 0.0 && plane[1].d >= 0.0 && plane[2].d >= 0.0;
  const bool is_outside_all = plane[0].d <= 0.0 && plane[1].d <= 0.0 && plane[2].d <= 0.0;
  if (!is_inside_all && !is_outside_all) return false;
  const Vec3 n = blend(plane);
  if (kind == SurfaceKind::corner_fan) {
    vcp.D = t.corner[0];
  } else {
    // The triangle's plane has shrunk to a line: D is the point on it closest to the line through P along n.
    const Vec3& a = t.corner[0];
    const Vec3 e = (t.corner[1] == a ? t.corner[2] : t.corner[1]) - a;
    const Vec3 r = P - a;
    const double en = e.dot(n);
    const double denominator = e.squaredNorm() - en * en;
    const double s = denominator > 0.0 ? (r.dot(e) - r.dot(n) * en) / denominator : r.dot(e) / e.squaredNorm();
    vcp.D = a + std::clamp(s, 0.0, 1.0) * e;
  }
  const Vec3 DP = P - vcp.D;
  vcp.distance = DP.norm();
  if (!(vcp.distance > 0.0 && vcp.distance < radius) || !(n.dot(DP) > 0.0)) return false;
  vcp.away = DP / vcp.distance;
  vcp.sign = is_inside_all ? 1 : -1;
  return true;
}

}  // namespace

bool find_vcp(const SetTriangle& triangle, const Vec3& P, double radius, SmoothVcp& vcp) noexcept {
  vcp.object = triangle.object;
  vcp.triangle = triangle.triangle;
  vcp.is_face = triangle.kind == SurfaceKind::face;
  if (vcp.is_face) {
    const double height = triangle.face_normal.dot(P - triangle.corner[0]);
    if (height > 0.0) return find_face_vcp(from_front(triangle), P, radius, vcp);
    return triangle.two_sided && height < 0.0 && find_face_vcp(from_behind(triangle), P, radius, vcp);
  }
  if (!is_near_fan(triangle, P, radius)) return false;
  return find_fan_vcp(from_front(triangle), triangle.kind, P, radius, vcp) ||
         (triangle.two_sided && find_fan_vcp(from_behind(triangle), triangle.kind, P, radius, vcp));
}

Vec3 smooth_normal_at(const SetTriangle& face, const Vec3& X) noexcept {
  std::array<EdgePlane, 3> plane;
  if (!make_planes(from_front(face), X, plane)) return face.face_normal;
  // Rounding may put X slightly outside a plane that it lies on.
  for (EdgePlane& one : plane) one.d = std::fmax(0.0, one.d);
  const Vec3 n = blend(plane);
  return n.allFinite() && n.dot(face.face_normal) > 0.0 ? n : face.face_normal;
}

StraightLine::StraightLine(const Vec3& from, const Vec3& to) noexcept : from_(from) {
  const Vec3 d = to - from;
  if (std::fabs(d.y()) > std::fabs(d[z_])) z_ = 1;
  if (std::fabs(d.z()) > std::fabs(d[z_])) z_ = 2;
  x_ = (z_ + 1) % 3;
  y_ = (z_ + 2) % 3;
  extent_z_ = d[z_];
  if (extent_z_ != 0.0) {
    shear_x_ = d[x_] / extent_z_;
    shear_y_ = d[y_] / extent_z_;
  }
}

void SmoothForceSum::add(const SetTriangle& triangle) noexcept {
  SmoothVcp vcp;
  if (!find_vcp(triangle, P_, radius_, vcp)) return;
  std::size_t slot = count_;
  if (count_ == kCapacity) {
    ++over_capacity_;
    const auto farthest = std::max_element(collected_.begin(), collected_.end(),
                                           [](const CollectedVcp& a, const CollectedVcp& b) { return a.vcp.distance < b.vcp.distance; });
    if (farthest->vcp.distance <= vcp.distance) return;
    slot = static_cast<std::size_t>(farthest - collected_.begin());
  } else {
    ++count_;
  }
  collected_[slot] = {vcp, triangle.corner};
}

// Fig. 3 (FDH): whether the line from the VCP to P passes through another triangle that has a VCP itself. The start of the line, on an
// edge that both share, does not count.
bool SmoothForceSum::is_hidden(std::size_t i) const noexcept {
  constexpr double kClear = 1e-6;  // share of |DP|
  const StraightLine line(collected_[i].vcp.D, P_);
  for (std::size_t j = 0; j < count_; ++j) {
    if (j == i || !collected_[j].vcp.is_face) continue;
    double at = 0.0;
    if (line.meets(collected_[j].corner, at) && at > kClear && at < 1.0 - kClear) return true;
  }
  return false;
}

SmoothForce SmoothForceSum::combine(double layer, std::span<const Material> materials) noexcept {
  SmoothForce result;
  result.vcps = static_cast<std::uint32_t>(count_);
  result.over_capacity = over_capacity_;
  std::sort(collected_.begin(), collected_.begin() + static_cast<std::ptrdiff_t>(count_), [](const CollectedVcp& a, const CollectedVcp& b) {
    return a.vcp.object != b.vcp.object ? a.vcp.object < b.vcp.object : a.vcp.triangle < b.vcp.triangle;
  });
  Vec3 force = Vec3::Zero();
  double max_force = 0.0;
  double nearest = 0.0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (is_hidden(i)) {
      ++result.hidden;
      continue;
    }
    const SmoothVcp& vcp = collected_[i].vcp;
    const double s = smooth_f(materials[vcp.object].stiffness_n_per_m, layer, vcp.distance);
    force += (vcp.sign * s) * vcp.away;
    if (vcp.sign < 0) continue;
    max_force = std::max(max_force, s);
    if (result.away.isZero(0.0) || vcp.distance < nearest) {
      nearest = vcp.distance;
      result.D = vcp.D;
      result.away = vcp.away;
    }
  }
  const double length = force.norm();
  // Forces that cancel have no direction.
  if (length > 1e-12 * max_force) result.force_n = force * (max_force / length);
  return result;
}

}  // namespace hapton
