#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "core/geometry/smooth_surface.h"
#include "core/math/types.h"

namespace hapton {

// One triangle with everything the fast task needs. Frame S, metres.
struct SetTriangle {
  std::array<Vec3, 3> corner;
  std::array<Vec3, 3> normal;       // unit, at the corners
  Vec3 face_normal = Vec3::Zero();  // unit normal of the triangle; zero for degenerate triangles
  std::uint32_t object = 0;
  std::uint32_t triangle = 0;  // number in the object's prepared surface (SmoothSurface)
  SurfaceKind kind = SurfaceKind::face;
  bool two_sided = true;
  bool consistently_oriented = true;  // the pieces of its object are consistently oriented, so the side of the normal is meaningful

  // The order in which contributions are summed, whatever order the triangles come in.
  bool before(const SetTriangle& other) const { return object != other.object ? object < other.object : triangle < other.triangle; }
};

// Request for a set: the triangles nearest to the path between two points.
struct LocalSetRequest {
  Vec3 from = Vec3::Zero();
  Vec3 to = Vec3::Zero();
};

// The triangles near a probe's predicted path: all that the fast task needs, of bounded size (FDH paper, section 3: the small subset of
// triangles). Every triangle of the scene that is nearer to the path than `radius` is in the set. A plain value without heap, so it fits
// into a mailbox between the slow and the fast task. Frame S, metres.
struct LocalSet {
  // Four times the usual set (MethodSettings::set_size). Limited because a set is copied between the tasks; FdhNearest::kMaxCount is equal.
  static constexpr std::uint32_t kCapacity = 256;

  Vec3 from = Vec3::Zero();  // start of the path
  Vec3 to = Vec3::Zero();
  double radius = -1.0;       // complete within this distance of the path; negative: nothing is known
  double nearest = 0.0;       // lower bound on the distance of any triangle from the path
  std::uint64_t version = 0;  // version of the scene that the set was taken from; the set is valid for it only
  std::uint32_t count = 0;
  std::array<SetTriangle, kCapacity> triangles;

  // Distance from p to the path. RT: yes.
  double distance_to_path(const Vec3& p) const {
    const Vec3 d = to - from;
    const double length_squared = d.squaredNorm();
    const double t = length_squared > 0.0 ? std::clamp((p - from).dot(d) / length_squared, 0.0, 1.0) : 0.0;
    return (p - (from + t * d)).norm();
  }
  // Radius round p within which the set is complete; negative if p is out of range. RT: yes.
  double radius_at(const Vec3& p) const { return radius - distance_to_path(p); }
  // Radius round p within which there is no triangle; zero or less: nothing is known. RT: yes.
  double clearance_at(const Vec3& p) const { return nearest - distance_to_path(p); }
};

// Whether the triangle is a face of the prepared surface, not of a fan, and has an area. RT: yes.
inline bool is_face(const SetTriangle& triangle) { return triangle.kind == SurfaceKind::face && !triangle.face_normal.isZero(0.0); }

}  // namespace hapton
