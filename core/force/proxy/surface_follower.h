#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/force/proxy/surface_friction.h"
#include "core/force/proxy/surface_point.h"
#include "core/force/step_work.h"

namespace hapton {

// A point held by a surface, following the device along its straight motion exactly, from event to event: the sweeping process of Moreau
// (1977) for the distance to the device. As long as the point is a local minimum of that distance it moves as an affine function of time,
// so the time of the next event is computed, not searched:
//
//   the point is on    its position is                        until
//   a face             the projection of the device           it reaches an edge; the device comes in front of the face
//   a concave edge     the projection onto the edge           it reaches an end; the multiplier of a face reaches zero
//   a vertex           that vertex                            an edge of the vertex leads nearer to the device
//
// At an event the device is held still and the point descends over the surface, in the steepest direction, to the next local minimum. Where
// the material has friction, SurfaceFriction decides when the point moves and how far. The path uses adjacency alone, so only walkable
// triangles (SurfaceAdjacency); it stops before any other.
//
// Frame: TouchGeometry's local one. RT: yes.
//
// Bounded: a call begins no event after StepWork::kMax units of work (step_work.h); one costs 1, at a large fan more; friction doubles it.
class SurfaceFollower {
 public:
  static constexpr int kFacetsPerUnit = 16;  // at a vertex, each 16 facets cost one unit more (measured at fans of 1,000)

  using Outcome = SurfaceNext;  // never `again` or `descend`

  // See SurfacePoint.
  SurfaceFollower(const TouchGeometry& geometry, std::span<const Material> materials) : at_(geometry, materials) {}

  const SurfacePoint& at() const { return at_; }
  bool is_on_surface() const { return at_.is_on_surface(); }
  const Vec3& point() const { return at_.point(); }
  bool slides() const { return friction_.slides(); }
  // Call when the friction of the materials has changed: the point may no longer be settled. Pre: is_on_surface().
  void note_friction() noexcept { friction_.begin(at_.material(), friction_.slides()); }
  Vec3 lifted(double height) noexcept { return at_.lifted_again(height); }
  void leave() { at_.leave(); }
  bool land(std::uint32_t triangle, bool back, const Vec3& p, bool slides = false) noexcept;
  bool land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p, bool slides = false) noexcept;

  // Moves the point to its local minimum while the device is held still. Pre: is_on_surface().
  Outcome descend(const Vec3& device, int most_work = StepWork::kMax) noexcept;
  // The device moves straight from `from` (time 0) to `to` (time 1). Follows it from `time` until the outcome and sets `time` to that
  // moment. Pre: is_on_surface(), settled at `time`.
  Outcome follow(const Vec3& from, const Vec3& to, double& time, int most_work = StepWork::kMax) noexcept;
  int work_left() const { return work_left_; }  // of the last call

  std::uint64_t events() const { return events_; }  // since construction

 private:
  using Next = SurfaceNext;
  // Local units. A minimum this near to a convex edge, with the device beyond, is an unstable equilibrium: no hand holds it, and a sphere,
  // however small, leaves it (decision 90). The contact offset of the sweeps is a quarter of this.
  static constexpr double kBalance = 0x1p-28;

  void spend() noexcept;
  Next next_descent(const Vec3& device) noexcept;
  Next next_event(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next settle_on_face(const Vec3& p, const Vec3& device) noexcept;
  Next settle_on_edge(double along, const Vec3& device) noexcept;
  bool is_near_end_of_edge() const noexcept;
  Next go_over_end(const Vec3& device) noexcept;
  Next descend_on_face(const Vec3& device) noexcept;
  Next descend_on_edge(const Vec3& device) noexcept;
  Next descend_at_vertex(const Vec3& device) noexcept;
  Next follow_on_face(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next follow_on_edge(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next follow_at_vertex(const Vec3& from, const Vec3& to, double& time) noexcept;

  SurfacePoint at_;
  SurfaceFriction friction_;
  int work_left_ = 0;
  std::uint64_t events_ = 0;
};

}  // namespace hapton
