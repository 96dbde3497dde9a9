#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/force/proxy/surface_friction.h"
#include "core/force/proxy/surface_point.h"

namespace hapton {

// A point held by a surface, which follows the device along its straight motion from event to event, exactly: it is the sweeping process of
// Moreau (1977) for the distance to the device. While the point is a local minimum of that distance it moves as an affine function of time,
// so the next change is computed and not searched for:
//
//   it stands on       it is                                   until
//   a face             the projection of the device             it reaches an edge; the device comes in front of the face
//   a concave edge     the projection onto the edge             it reaches an end; the multiplier of a face reaches zero
//   a vertex           that vertex                              an edge round it leads nearer to the device
//
// At an event the device is held and the point descends over the surface, the steepest way, to the next local minimum. Where the material
// has friction, SurfaceFriction says what moves it and what holds it. It finds its way by adjacency alone, so only over walkable triangles
// (SurfaceAdjacency); it stops before any other.
//
// Frame: TouchGeometry's local one. RT: yes.
//
// Bounded: a call has kLeastEvents events, and kEventsPerEdge more for each edge that a straight way over the object's surface crosses on
// the average, as long as the device's way and twice the pull; kMostEvents in all.
class SurfaceFollower {
 public:
  static constexpr int kLeastEvents = 1024;
  static constexpr double kEventsPerEdge = 32.0;
  static constexpr int kMostEvents = 16384;
  static constexpr int kFacetsPerEvent = 16;  // round a vertex

  enum class Outcome : std::uint8_t {
    settled,     // at a local minimum for the device where it is at `time`, or held by friction
    airborne,    // the device is on the free side: the point leaves the surface, straight towards it
    released,    // the device has come to the surface from behind, where the point is: they leave it together
    unwalkable,  // the way leads to a triangle that cannot be walked; the point stands on a face just before it
    exhausted,   // out of events: short of the minimum, to go on from there
  };

  // As SurfacePoint's.
  SurfaceFollower(const TouchGeometry& geometry, std::span<const Material> materials) : at_(geometry, materials) {}

  const SurfacePoint& at() const { return at_; }
  bool stands() const { return at_.stands(); }
  const Vec3& point() const { return at_.point(); }
  bool slides() const { return friction_.slides(); }
  void leave() { at_.leave(); }
  bool land(std::uint32_t triangle, bool back, const Vec3& p, bool slides = false) noexcept;
  bool land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p, bool slides = false) noexcept;

  // With the device held. Pre: stands.
  Outcome descend(const Vec3& device) noexcept;
  // The device goes straight from `from` to `to`, where it is at time 0 and 1; it is followed from `time` until the outcome, whose time
  // that is then. Pre: stands; settled at `time`.
  Outcome follow(const Vec3& from, const Vec3& to, double& time) noexcept;

  std::uint64_t events() const { return events_; }  // since it was made

 private:
  using Next = SurfaceNext;
  // As near to a convex edge it balances there. It is what the hover of a sphere stands for, four times.
  static constexpr double kBalance = 0x1p-28;

  static Outcome outcome_of(Next next) noexcept;
  void spend() noexcept;
  int most_events(double way, const Vec3& device) const noexcept;
  Next next_descent(const Vec3& device) noexcept;
  Next next_event(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next settle_on_face(const Vec3& p, const Vec3& device) noexcept;
  Next descend_on_face(const Vec3& device) noexcept;
  Next descend_on_edge(const Vec3& device) noexcept;
  Next descend_at_vertex(const Vec3& device) noexcept;
  Next follow_on_face(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next follow_on_edge(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next follow_at_vertex(const Vec3& from, const Vec3& to, double& time) noexcept;

  SurfacePoint at_;
  SurfaceFriction friction_;
  int budget_ = 0;
  std::uint64_t events_ = 0;
};

}  // namespace hapton
