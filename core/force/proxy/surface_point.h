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

// What follows an event on the surface. All but the first two end a call of SurfaceFollower.
enum class SurfaceNext : std::uint8_t {
  again,       // continue from the point's new position
  descend,     // first descend to the next local minimum, with the device held
  settled,     // at a local minimum for the device at that time, or held by friction
  airborne,    // the device is on the free side: the point leaves the surface, straight towards the device
  released,    // the device has come to the surface from behind at the point: both leave it together
  unwalkable,  // the path leads to a triangle that is not walkable; the point is on a face just before it
  exhausted,   // the work was used up before the minimum; the next call continues
};

// A point on one side of a surface: on a face, an edge or a vertex, with the moves that it can make. It moves by adjacency alone, so
// only over walkable triangles (SurfaceAdjacency). SurfaceFollower and SurfaceFriction decide where it goes.
//
// Frame: TouchGeometry's local one. RT: yes.
class SurfacePoint {
 public:
  // A device no farther than this in front of a face counts as on it: 512 times the rounding of a height, so a device beyond it is
  // certainly off the surface. Local units, as all lengths here.
  static constexpr double kClear = 0x1p-43;
  // A point this near to a vertex is moved onto it: 16 times the rounding of a local coordinate, far below the height of any walkable
  // triangle.
  static constexpr double kSnap = 0x1p-46;
  // Hysteresis against rounding: the point leaves a face when the projection of the device is this far outside its edge, and enters one
  // when the projection is this far inside.
  static constexpr double kOnEdge = 0x1p-44;
  // At a vertex the point stays until the device is this far away: below it, the direction to the device is mostly rounding.
  static constexpr double kMinPull = 0x1p-42;

  using On = Feature;

  struct Facet {
    std::uint32_t id = 0;
    double side = 1.0;  // 1: front; -1: back
    ContactTriangle shape;
    Vec3 normal() const { return side * shape.normal(); }
    double height(const Vec3& p) const { return side * shape.normal().dot(p - shape.corner(0)); }
    bool is_back() const { return side < 0.0; }
  };
  // A triangle side in the fan of the vertex that the point is on.
  struct FanFacet {
    std::uint32_t id = 0;
    bool back = false;
    int corner = 0;                 // number of the vertex in the triangle
    int next = 0;                   // number of the edge shared with the next facet of the fan
    Vec3 normal = Vec3::Zero();     // unit, on this side
    Vec3 inward[2];                 // in the plane, perpendicular to each of the two edges at the vertex, towards the inside
    Vec3 direction = Vec3::Zero();  // unit, along edge `next` away from the vertex
  };
  // A face that holds the point, with the side that the point is on.
  struct Contact {
    std::uint32_t triangle = 0;
    Vec3 normal = Vec3::Zero();  // unit, towards the point
    double multiplier = 0.0;     // point - device = sum of multiplier * normal, without friction
  };

  // materials: one for each object; they say which sides can hold a point. Both outlive this object.
  SurfacePoint(const TouchGeometry& geometry, std::span<const Material> materials) : geometry_(geometry), materials_(materials) {}

  bool is_on_surface() const { return is_on_surface_; }
  const Vec3& point() const { return p_; }
  On on() const { return on_; }
  // The face that the point is on, or one face at its edge or vertex. Pre, to load_adjacent() without leave() and land: is_on_surface().
  const Facet& a() const { return facets_[first_]; }
  // On an edge: the adjacent face. The edge has the number edge() in a(), and other_edge() in b().
  const Facet& b() const { return facets_[1 - first_]; }
  int edge() const { return edge_; }
  int other_edge() const { return other_edge_; }
  bool has_left_a() const { return has_left_a_; }  // the point came to the edge over a(), so a() leads no nearer to the device
  int entry_edge() const { return entry_edge_; }   // on a face: the edge over which the point entered it, or -1
  int corner() const { return corner_; }           // number in a() of the point's vertex; on a face of the one it came from, or -1
  std::span<const FanFacet> fan() const { return {fan_.data(), static_cast<std::size_t>(fan_count_)}; }  // at a vertex, in order
  const Material& material() const { return materials_[geometry_.mesh_of(a().id)]; }

  void leave() { is_on_surface_ = false; }
  // Puts the point on one side of a triangle. Returns false, and changes nothing, if it is not walkable or cannot be touched on that side.
  bool land(std::uint32_t triangle, bool back, const Vec3& p) noexcept;
  // The same on edge k of the triangle. Also returns false, and changes nothing, if that holds for the adjacent triangle or there is none.
  bool land_on_edge(std::uint32_t triangle, bool back, int k, const Vec3& p) noexcept;

  // Moves the point within the face a().
  void move_on_face(const Vec3& p) noexcept;
  // Moves the point to p on edge k of a(), or to the end vertex of the edge if p is there. Returns false if a triangle there is not
  // walkable or cannot be touched on that side; the point is then on a(), just before it.
  bool reach_edge(int k, const Vec3& p) noexcept;
  bool reach_vertex(int corner) noexcept;
  // On an edge, in order: moves along it, 0 to 1 in a()'s direction; onto b(), which becomes a(); onto a(); forgets the entry from a().
  void move_on_edge(double along) noexcept;
  void cross_edge() noexcept;
  void return_from_edge() noexcept;
  void balance_on_edge() noexcept { has_left_a_ = false; }
  // Loads the face adjacent to edge k of a() as b(). Returns false if there is none, or it is not walkable or cannot be touched.
  bool load_adjacent(int k) noexcept;
  // As seen from the side of a(). A boundary edge counts as convex. Pre: b() is the face across edge().
  bool is_convex() const noexcept;
  bool is_free_over_edge(const Vec3& device) const noexcept;
  // At a vertex: whether the device is off the surface. Pre: the vertex is the point of its faces that is nearest to the device.
  bool is_free_at_vertex(const Vec3& to_device) const noexcept;
  // At a vertex, visible from p: whether p is on the fan's side of the surface. Exact, except between equally near features.
  bool is_before_fan(const Vec3& p) const noexcept;
  // Descent shorter than this is not followed: its slope is only rounding.
  double least_slope(const Vec3& device) const noexcept { return kMinPull + 0x1p-40 * (device - p_).norm(); }
  // How far inside edge k the projection of the device on a facet lies, less `margin`, times the edge's length.
  static double inside_by(double margin, const Facet& facet, int k, const Vec3& device) noexcept {
    return facet.shape.inside(k, device) - margin * facet.shape.length(k);
  }

  // On an edge: the face that leads nearer to the device; if both do, the one in which its projection lies farther inside; null: neither.
  const Facet* find_over_edge(const Vec3& device) const noexcept {
    const double in_a = has_left_a_ ? 0.0 : inside_by(kOnEdge, a(), edge_, device);
    const double in_b = inside_by(kOnEdge, b(), other_edge_, device);
    const bool to_a = in_a > 0.0 && a().height(device) <= kClear;
    const bool to_b = in_b > 0.0 && b().height(device) <= kClear;
    if (to_b && !(to_a && in_a > in_b)) return &b();
    return to_a ? &a() : nullptr;
  }
  // From the edge onto one of its faces.
  void leave_edge(const Facet& over) noexcept { &over == &b() ? cross_edge() : return_from_edge(); }

  // On a face: the first edge on the straight path to a goal in its plane, and the share of the path up to it. edge -1: none.
  struct Exit {
    int edge = -1;
    double time = 2.0;
  };
  Exit find_exit(const Vec3& goal) const noexcept;
  // At a vertex: the face, or the edge after it, that leads farthest towards the device: its point nearest to the device is farther from
  // the vertex than `least`, and than such a point of any other. facet is nullptr if there is none.
  struct Descent {
    const FanFacet* facet = nullptr;
    bool over_face = false;
    double length = 0.0;
  };
  Descent find_steepest(const Vec3& to_device, double least) const noexcept;
  // Whether the device is on the free side of what that descent leads over. Pre: descent.facet is not null.
  bool is_free_along(const Descent& descent, const Vec3& to_device) const noexcept;
  SurfaceNext descend_along(const Descent& descent, const Vec3& device) noexcept;
  // The device comes to the free side of the face a() at `device`, on its way to `to`: moves the point to that place.
  SurfaceNext release(const Vec3& device, const Vec3& to) noexcept;

  // The point, moved in the face a() by `off_edges` towards its middle, at most half of the way.
  Vec3 inside(double off_edges) const noexcept;
  // The point lifted off the surface: `height` above the faces that it is on, and above the faces beyond concave edges nearby, so that it
  // does not enter a face that it only approaches. At a vertex the result may lie beside the vertex.
  Vec3 lifted(double height) const noexcept;
  // The same. At a vertex it is computed once: there the point does not move for many steps.
  Vec3 lifted_again(double height) noexcept;
  // Where a flight to a device on the free side starts, so that the surface next to the point does not stop it: at a vertex on the straight
  // path itself, at the boundary of a sheet beside the sheet, otherwise lifted().
  Vec3 lifted_towards(const Vec3& device, double height) const noexcept;
  // The faces that hold the point, at most three (at a fan of more than kMaxPlanes facets one); returns their number. The sum of
  // multiplier * normal is point - device only if the point has settled without friction.
  int find_contacts(const Vec3& device, std::array<Contact, 3>& contacts) const noexcept;

 private:
  static constexpr int kMaxFan = 2 * SurfaceAdjacency::kMaxValence;
  static constexpr int kMaxPlanes = 256;                // a larger fan is handled facet by facet
  static constexpr double kMaxLift = 4096.0;            // largest length of a lift, in heights
  static constexpr int kMaxTriedFacets = 16;            // facets of a fan that a lift may be based on
  static constexpr int kMaxNear = 64;                   // faces examined for a lift
  static constexpr double kAllButFlat = 1.0 - 0x1p-21;  // cosine of a milliradian

  Facet& face_a() { return facets_[first_]; }
  bool can_hold(std::uint32_t triangle, bool back) const noexcept;
  void load(std::uint32_t id, bool back, Facet& facet) const noexcept;
  bool collect_fan() noexcept;
  void turn_to(const FanFacet& facet) noexcept;
  bool enter_edge(const FanFacet& facet) noexcept;
  Vec3 vertex_normal() const noexcept;
  bool is_at_boundary() const noexcept;  // at a vertex: the fan contains both sides of an open sheet
  bool is_before(const FanFacet& facet, const Vec3& p) const noexcept;
  static Vec3 lift_between(const Vec3& normal_a, const Vec3& normal_b, double height) noexcept;
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
  bool is_on_surface_ = false;
  On on_ = On::face;
  Vec3 p_ = Vec3::Zero();
  std::array<Facet, 2> facets_;
  int first_ = 0;
  int edge_ = 0;
  int other_edge_ = 0;
  bool has_left_a_ = false;
  int entry_edge_ = -1;
  int corner_ = -1;
  std::array<FanFacet, kMaxFan> fan_;
  int fan_count_ = 0;
  struct VertexLift {
    double height = 0.0;  // 0: not computed
    Vec3 point = Vec3::Zero();
  } vertex_lift_;
};

}  // namespace hapton
