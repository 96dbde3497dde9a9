#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>

#include "core/geometry/smooth_surface.h"
#include "core/math/types.h"

namespace hapton {

// One triangle as the fast task sees it: nothing to look up any more. Frame S, metres.
struct SetTriangle {
  std::array<Vec3, 3> corner;
  std::array<Vec3, 3> normal;  // unit, of the corners
  Vec3 face = Vec3::Zero();    // unit normal of the triangle itself; zero for fake triangles and those without area
  std::uint32_t object = 0;
  std::uint32_t triangle = 0;  // of the object's prepared surface
  SurfaceKind kind = SurfaceKind::face;
  bool two_sided = true;
  bool one_winding = true;  // its object's pieces are each wound one way: the side that the normal points to means something
  double stiffness_n_per_m = 0.0;

  // The one order in which contributions are added, whatever order the triangles come in.
  bool before(const SetTriangle& other) const { return object != other.object ? object < other.object : triangle < other.triangle; }
};

// Where a set is wanted: the triangles nearest to the way between two points.
struct LocalSetRequest {
  Vec3 from = Vec3::Zero();
  Vec3 to = Vec3::Zero();
};

// The triangles near a probe's predicted way: all that the fast task needs, of bounded size (fdh-rendering.txt, section 3: the small
// subset of triangles). It knows how far it can be trusted: every triangle of the scene nearer to the way than radius is in it.
// A plain value without heap: it can lie in a mailbox between the slow task and the fast one.
struct LocalSet {
  static constexpr std::uint32_t kCapacity = 256;

  Vec3 from = Vec3::Zero();  // the way
  Vec3 to = Vec3::Zero();
  double radius = -1.0;       // complete within; negative: nothing is known
  double nearest = 0.0;       // no triangle of the scene is nearer to the way than this
  std::uint64_t version = 0;  // of the scene that it was taken from; another version of the scene makes it worthless
  std::uint32_t count = 0;
  std::array<SetTriangle, kCapacity> triangles;

  // The distance from p to the way.
  double distance_to_way(const Vec3& p) const {
    const Vec3 d = to - from;
    const double length_squared = d.squaredNorm();
    const double t = length_squared > 0.0 ? std::clamp((p - from).dot(d) / length_squared, 0.0, 1.0) : 0.0;
    return (p - (from + t * d)).norm();
  }
  // How far round p every triangle of the scene is in the set; negative when p is out of its reach. RT: yes.
  double reach_at(const Vec3& p) const { return radius - distance_to_way(p); }
  // How far round p there is no triangle at all, at least.
  double clearance_at(const Vec3& p) const { return nearest - distance_to_way(p); }
};

// A triangle of the mesh itself, with an area. RT: yes.
inline bool is_face(const SetTriangle& triangle) { return triangle.kind == SurfaceKind::face && !triangle.face.isZero(0.0); }

}  // namespace hapton
