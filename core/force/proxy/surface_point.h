#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "core/collision/touch_geometry.h"
#include "core/force/touch_scene.h"
#include "core/geometry/contact_triangle.h"
#include "core/math/straight_motion.h"

namespace hapton {

// What follows an event on the surface.
enum class SurfaceNext : std::uint8_t {
  again,       // go on from where the point stands now
  descend,     // the device held, first descend to the next place of rest
  settled,     // at rest
  airborne,    // the device is on the free side: straight towards it
  released,    // the device has come to the surface where the point is
  unwalkable,  // the way leads to what cannot be walked
};

// A point on a side of a surface: on a face, an edge or a vertex, and what leads on from there. It goes by adjacency alone, so only over
// walkable triangles (SurfaceAdjacency). Where it goes is for others to say (SurfaceFollower, SurfaceFriction).
//
// Frame: TouchGeometry's local one. RT: yes.
class SurfacePoint {
 public:
  // A device no farther than this in front of a face is still at it: 512 times the rounding of a height, so that what is off the surface is
  // so beyond doubt. Local units, as all lengths here.
  static constexpr double kClear = 0x1p-43;
  // A point as near to a vertex is taken to be there: 16 times the rounding of a local coordinate, far below any walkable triangle's
  // height.
  static constexpr double kSnap = 0x1p-46;
  // A face is left where the projection of the device is so far beyond its edge, and entered where it is so far inside: between, either
  // stays as it is, and rounding does not lead back and forth.
  static constexpr double kOnEdge = 0x1p-44;
  // At a vertex it stays until the device draws it as far: the direction to a device nearer than this is mostly rounding.
  static constexpr double kLeastWay = 0x1p-42;

  enum class On : std::uint8_t { face, edge, vertex };

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
  // A face that holds the point, with the side it is on.
  struct Contact {
    std::uint32_t triangle = 0;
    Vec3 normal = Vec3::Zero();  // unit, towards the point
    double multiplier = 0.0;     // point - device = sum of multiplier * normal, without friction
  };
  // A point of a face it stands on, a little off every edge and vertex, and the way off the surface there.
  struct Inside {
    std::uint32_t triangle;
    Vec3 point;
    Vec3 normal;  // unit
  };

  // `materials`: one an object; whether a side holds is theirs to say. Both outlive it.
  SurfacePoint(const TouchGeometry& geometry, std::span<const Material> materials) : geometry_(geometry), materials_(materials) {}

  bool stands() const { return stands_; }
  const Vec3& point() const { return p_; }
  On on() const { return on_; }
  // The face it stands on, of one side of the edge, of one at the vertex. The rest, down to look_across(), needs stands().
  const Facet& a() const { return facets_[first_]; }
  // On an edge, edge() of a(): the face across, and the edge's number there.
  const Facet& b() const { return facets_[1 - first_]; }
  int edge() const { return edge_; }
  int other_edge() const { return other_edge_; }
  bool has_left_a() const { return has_left_a_; }  // it came to the edge over a(), which leads no farther
  int came_by() const { return came_by_; }         // on a face: the edge it came by, or -1
  int corner() const { return corner_; }           // of a(): the vertex it stands at; on a face the one it came from, or -1
  std::span<const FanFacet> fan() const { return {fan_.data(), static_cast<std::size_t>(fan_count_)}; }  // at a vertex, in order
  double edges_per_length() const { return geometry_.edges_per_length(a().id); }                         // ObjectGeometry's
  const Material& material() const { return materials_[geometry_.mesh_of(a().id)]; }

  void leave() { stands_ = false; }
  // Puts the point on a side of a walkable triangle. False, and nothing changed, where that side holds nothing.
  bool land(std::uint32_t triangle, bool back, const Vec3& p) noexcept;
  // The same on edge k of the triangle. False, and nothing changed, also where the side across that edge is not walkable or holds nothing.
  bool land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p) noexcept;

  // On the face a(), inside.
  void move_on_face(const Vec3& p) noexcept;
  // To edge k of a(), or the vertex that ends it there. False before what cannot be walked: it stands on the face just before.
  bool reach_edge(int k, const Vec3& p) noexcept;
  bool reach_vertex(int corner) noexcept;
  // On an edge: along it, from 0 to 1 (a()'s direction); onto b(), which becomes a(); onto a(); and no longer as who has left a().
  void move_on_edge(double along) noexcept;
  void cross_edge() noexcept;
  void return_from_edge() noexcept;
  void balance_on_edge() noexcept { has_left_a_ = false; }
  // Loads the face across edge k of a() as b(), and edge(), wherever it stands. False where there is none to walk on.
  bool look_across(int k) noexcept;
  // As seen from the side of a(). A boundary edge is the sharpest there is. Pre: b() is the face across edge().
  bool is_convex() const noexcept;
  bool is_free_over_edge(const Vec3& device) const noexcept;
  // Whether a direction that leads farther from every edge and face round the vertex leads off the surface.
  bool is_free_at_vertex(const Vec3& to_device) const noexcept;
  // At a vertex: whether a point from which a straight way leads there is on the side of the surface that the fan shows. Exact.
  bool is_before_fan(const Vec3& p) const noexcept;
  // A way nearer to the device that is no longer than this is none: its slope is all rounding.
  double least_slope(const Vec3& device) const noexcept { return kLeastWay + 0x1p-40 * (device - p_).norm(); }
  // How far inside edge k the projection of the device on a facet lies, less `margin`; times the edge's length.
  static double inside_by(double margin, const Facet& facet, int k, const Vec3& device) noexcept {
    return facet.shape.inside(k, device) - margin * facet.shape.length(k);
  }

  // On a face: the edge that the straight way to a goal in its plane crosses first, and after what share of it. -1: none.
  struct Exit {
    int edge = -1;
    double time = 2.0;
  };
  Exit find_exit(const Vec3& goal) const noexcept;
  // At a vertex: the face, or the edge after it, on which a point nearest to the device lies farthest away, beyond `least`. nullptr: none.
  struct Way {
    const FanFacet* facet = nullptr;
    bool over_face = false;
    double length = 0.0;
  };
  Way find_steepest(const Vec3& to_device, double least) const noexcept;
  SurfaceNext take(const Way& way, const Vec3& device) noexcept;
  // The device comes to the free side of the face a() at `device`, on its way to `to`: the point goes there.
  SurfaceNext release(const Vec3& device, const Vec3& to) noexcept;

  Inside inside(double off_edges) const noexcept;
  // The point moved off the surface, to `height` over the faces that it stands on and those beyond concave edges near, at a vertex beside
  // it as well: so never into a face that it only comes up to.
  Vec3 lifted(double height) const noexcept;
  // The same to where a flight to a device on the free side begins, which the surface next to the point must not stop: at a vertex on the
  // way itself, at the border of a sheet beside it.
  Vec3 lifted_towards(const Vec3& device, double height) const noexcept;
  // What holds the point, at most three faces; multipliers sum up only when it has settled without friction. Returns their number.
  int find_contacts(const Vec3& device, std::array<Contact, 3>& contacts) const noexcept;

 private:
  static constexpr int kMostFan = 2 * SurfaceAdjacency::kMostValence;
  static constexpr int kMostPlanes = 256;               // a larger fan is looked at facet by facet
  static constexpr double kSteepest = 4096.0;           // of a lift's height: how far it may lead
  static constexpr int kMostTried = 16;                 // faces of a fan that a lift may lead over
  static constexpr int kMostNear = 64;                  // faces looked at for a lift
  static constexpr double kAllButFlat = 1.0 - 0x1p-21;  // the cosine of a milliradian

  Facet& face_a() { return facets_[first_]; }
  bool holds(std::uint32_t triangle, bool back) const noexcept;
  void load(std::uint32_t id, bool back, Facet& facet) const noexcept;
  bool collect_fan() noexcept;
  void turn_to(const FanFacet& facet) noexcept;
  bool enter_edge(const FanFacet& facet) noexcept;
  Vec3 vertex_normal() const noexcept;
  bool is_at_border() const noexcept;  // at a vertex: the fan goes round both sides of an open sheet
  bool is_before(const FanFacet& facet, const Vec3& p) const noexcept;
  static Vec3 between(const Vec3& normal_a, const Vec3& normal_b, double height) noexcept;
  [[gnu::noinline]] Vec3 lifted_over_all(double height) const noexcept;
  bool is_near_edges(double within) const noexcept;
  const Vec3& edge_before(int i) const noexcept;
  double distance_from_facet(int i, const Vec3& p) const noexcept;
  Vec3 over_widest_face(double height) const noexcept;
  Vec3 lifted_over_fan(double height) const noexcept;
  bool is_near_edge(const Facet& facet, int k, double within) const noexcept;
  template <class Add>
  void add_near_planes(double height, Add&& add) const noexcept;

  const TouchGeometry& geometry_;
  std::span<const Material> materials_;
  bool stands_ = false;
  On on_ = On::face;
  Vec3 p_ = Vec3::Zero();
  std::array<Facet, 2> facets_;
  int first_ = 0;
  int edge_ = 0;
  int other_edge_ = 0;
  bool has_left_a_ = false;
  int came_by_ = -1;
  int corner_ = -1;
  std::array<FanFacet, kMostFan> fan_;
  int fan_count_ = 0;
};

}  // namespace hapton
