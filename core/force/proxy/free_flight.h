#pragma once

#include <algorithm>
#include <array>

#include "core/collision/swept_sphere.h"
#include "core/force/contact_qp.h"
#include "core/force/proxy/proxy_state.h"
#include "core/force/proxy/surface_follower.h"

namespace hapton {

// Straight motions of a point that no surface holds. Frame: TouchGeometry's local one. RT: yes. Keeps references.
class FreeFlight {
 public:
  // Least work of a flight, in units (step_work.h); it costs one for each SurfaceFollower::kFacetsPerUnit triangles that it tests. A flight
  // is not interrupted: where thousands of triangles meet, a single one may use up the work of a step.
  static constexpr int kMinWork = 16;
  enum class Met : std::uint8_t { nothing, walkable, other };

  // clearance: the distances that sweeps keep from triangles.
  FreeFlight(const ProxySurfaces& surfaces, const Clearance& clearance)
      : surfaces_(surfaces), clearance_(clearance), vertex_(surfaces.geometry(), surfaces.materials()) {}

  // Moves the point from `from` to `to`. Met::walkable: it has reached a walkable triangle and is on `surface` now, where it slides or
  // sticks as `slides` says; `time` is the share of the motion, 0 to 1, at the contact. Met::other: the path first comes to a triangle that
  // is not walkable, as near as sweeps allow.
  Met fly(const Vec3& from, const Vec3& to, bool slides, SurfaceFollower& surface, double& time) noexcept;
  // Of the last flight, in units (step_work.h).
  int work() const { return std::max(kMinWork, tests_ / SurfaceFollower::kFacetsPerUnit); }

  // A free point may be nearer to triangles than sweeps allow. Returns the nearest position on the same side of them that is far enough;
  // p itself if that is farther from p than `farthest`, or if another triangle is in the way.
  Vec3 clear_of_surfaces(const Vec3& p, double farthest) noexcept;

  // Returns p, or if p is nearer to a triangle than `least`, p moved by twice `least` to the front of the nearest triangle, along the
  // normal of its vertex order; at an edge or a vertex the same for each face in turn.
  Vec3 off_surface(const Vec3& p, double least) const noexcept;

 private:
  bool is_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, const Vec3& hit) noexcept;
  bool is_vertex_seen_from(const Vec3& p, const Vec3& to, std::uint32_t id, bool back, int k, const Vec3& hit) noexcept;

  const ProxySurfaces& surfaces_;
  Clearance clearance_;
  SurfacePoint vertex_;  // scratch: the vertex that a flight reaches
  std::array<ContactPlane, ProxyState::kMaxContacts> planes_;
  int tests_ = 0;  // triangles that the last flight tested
};

}  // namespace hapton
