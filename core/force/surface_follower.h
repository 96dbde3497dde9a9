#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/collision/touch_geometry.h"
#include "core/geometry/contact_triangle.h"

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
// At an event the device is held and the point descends over the surface, the steepest way, to the next local minimum. It finds its way by
// adjacency alone, so only over walkable triangles (SurfaceAdjacency); it stops before any other.
//
// Frame: TouchGeometry's local one. RT: yes. Bounded: kMostEvents events a call.
class SurfaceFollower {
 public:
  static constexpr int kMostEvents = 8192;
  // A device no farther than this in front of a face is still at it: 512 times the rounding of a height, so that what is off the surface is
  // so beyond doubt. Local units, as all lengths here.
  static constexpr double kClear = 0x1p-43;

  enum class Outcome : std::uint8_t {
    settled,     // at a local minimum for the device where it is at `time`
    airborne,    // the device is on the free side: the point leaves the surface, straight towards it
    released,    // the device has come to the surface from behind, where the point is: they leave it together
    unwalkable,  // the way leads to a triangle that cannot be walked; the point stands on a face just before it
    exhausted,   // out of events: short of the minimum, to go on from there
  };

  // A face that holds the point, with the side it is on.
  struct Contact {
    std::uint32_t triangle = 0;
    Vec3 normal = Vec3::Zero();  // unit, towards the point
    double multiplier = 0.0;     // point - device = sum of multiplier * normal
  };

  // `one_sided`: per object, its triangles hold only from the front. Both outlive it.
  SurfaceFollower(const TouchGeometry& geometry, std::span<const std::uint8_t> one_sided) : geometry_(geometry), one_sided_(one_sided) {}

  bool stands() const { return stands_; }
  const Vec3& point() const { return p_; }
  void leave() { stands_ = false; }

  // Puts the point on a side of a walkable triangle. False, and nothing changed, where that side holds nothing.
  bool land(std::uint32_t triangle, bool back, const Vec3& p) noexcept;
  // The same on edge k of the triangle: its neighbour must be walkable, too.
  bool land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p) noexcept;

  // With the device held. Pre: stands.
  Outcome descend(const Vec3& device) noexcept;
  // The device goes straight from `from` to `to`, where it is at time 0 and 1; it is followed from `time` until the outcome, whose time
  // that is then. Pre: stands; settled at `time`.
  Outcome follow(const Vec3& from, const Vec3& to, double& time) noexcept;

  // A point of a face it stands on, a little off every edge and vertex, and the way off the surface there.
  struct Inside {
    std::uint32_t triangle;
    Vec3 point;
    Vec3 normal;  // unit
  };
  Inside inside(double off_edges) const noexcept;

  // The point moved off the surface, to `height` over the faces that it stands on and those beyond concave edges near.
  Vec3 lifted(double height) const noexcept;

  // What holds the point, at most three faces; multipliers sum up only when it has settled. Returns their number.
  int find_contacts(const Vec3& device, std::array<Contact, 3>& contacts) const noexcept;
  std::uint32_t first_triangle() const { return a().id; }
  std::uint64_t events() const { return events_; }  // since it was made

 private:
  static constexpr int kMostFan = 2 * SurfaceAdjacency::kMostValence;
  // A point as near to a vertex is taken to be there: 16 times the rounding of a local coordinate, far below any walkable triangle's
  // height.
  static constexpr double kSnap = 0x1p-46;
  // A face is left where the projection of the device is so far beyond its edge, and entered where it is so far inside: between, either
  // stays as it is, and rounding does not lead back and forth.
  static constexpr double kOnEdge = 0x1p-44;
  // As near to a convex edge it balances there. It is what the hover of a sphere stands for, four times.
  static constexpr double kBalance = 0x1p-28;
  // At a vertex it stays until the device draws it as far: the direction to a device nearer than this is mostly rounding.
  static constexpr double kLeastWay = 0x1p-42;

  static constexpr double kSteepest = 4096.0;  // of a lift's height: how far it may lead

  enum class Stand : std::uint8_t { face, edge, vertex };
  enum class Next : std::uint8_t { again, settled, airborne, released, unwalkable, descend };

  struct Facet {
    std::uint32_t id = 0;
    double side = 1.0;  // -1: its back
    ContactTriangle shape;
    Vec3 normal() const { return side * shape.normal(); }
    double height(const Vec3& p) const { return side * shape.normal().dot(p - shape.corner(0)); }
    bool is_back() const { return side < 0.0; }
  };
  // A triangle side at the vertex the point stands on.
  struct FanFacet {
    std::uint32_t id = 0;
    bool back = false;
    int corner = 0;                 // the vertex
    int next = 0;                   // the edge shared with the next of the fan
    Vec3 normal = Vec3::Zero();     // unit, of the side
    Vec3 inward[2];                 // in the plane, off the two edges at the vertex
    Vec3 direction = Vec3::Zero();  // unit, along edge `next` away from the vertex
  };

  static Outcome outcome_of(Next next) noexcept;
  Facet& a() { return facets_[first_]; }
  const Facet& a() const { return facets_[first_]; }
  Facet& b() { return facets_[1 - first_]; }
  const Facet& b() const { return facets_[1 - first_]; }

  bool holds(std::uint32_t triangle, bool back) const noexcept;
  void load(std::uint32_t id, bool back, Facet& facet) const noexcept;
  bool load_neighbour() noexcept;
  bool is_convex() const noexcept;
  static double inside_by(double margin, const Facet& facet, int k, const Vec3& device) noexcept;
  Next settle_on_face(const Vec3& p, const Vec3& device) noexcept;
  bool is_free_over_edge(const Vec3& device) const noexcept;
  void stand_on_face(const Vec3& p) noexcept;
  void cross_edge() noexcept;

  Next descend_on_face(const Vec3& device) noexcept;
  Next descend_on_edge(const Vec3& device) noexcept;
  Next descend_at_vertex(const Vec3& device) noexcept;
  Next reach_edge(int k, const Vec3& p) noexcept;
  Next reach_vertex(int corner) noexcept;
  Next follow_on_face(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next follow_on_edge(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next follow_at_vertex(const Vec3& from, const Vec3& to, double& time) noexcept;
  Next release(const Vec3& at, const Vec3& to) noexcept;
  bool collect_fan() noexcept;
  static Vec3 between(const Vec3& normal_a, const Vec3& normal_b, double height) noexcept;
  template <class Add>
  void add_near_planes(double height, Add&& add) const noexcept;
  bool is_free_at_vertex(const Vec3& to_device) const noexcept;
  double least_slope(const Vec3& device) const noexcept;

  const TouchGeometry& geometry_;
  std::span<const std::uint8_t> one_sided_;
  bool stands_ = false;
  Stand on_ = Stand::face;
  Vec3 p_ = Vec3::Zero();
  std::array<Facet, 2> facets_;  // the one it stands on, and the one across edge_
  int first_ = 0;
  int edge_ = 0;             // of a(), where it stands on one,
  int other_edge_ = 0;       // as b() numbers it
  bool has_left_a_ = false;  // it came to the edge over a(), which leads no farther
  int came_by_ = -1;         // on a face: the edge it came by, or -1
  int corner_ = -1;          // of a(): the vertex it stands at; on a face the one it came from, or -1
  std::array<FanFacet, kMostFan> fan_;
  int fan_count_ = 0;
  int budget_ = 0;
  std::uint64_t events_ = 0;
};

}  // namespace hapton
