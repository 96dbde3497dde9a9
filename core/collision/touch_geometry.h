#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "core/base/result.h"
#include "core/collision/built_objects.h"
#include "core/collision/object_geometry.h"
#include "core/collision/object_hierarchy.h"

namespace hapton {

// When the structures of the objects are built: all at once, or each when the probe first comes near it. to_deform: at once, for a single
// object whose vertices will move within the box part_of.
enum class BuildPolicy : std::uint8_t { at_once, on_approach, to_deform };

// All triangles of a scene for contact queries in one local frame: a hierarchy over the objects, and under each object the tree over its
// triangles. The cost of a query depends on the triangles near it, not on the number of objects.
//
// Triangles are numbered across objects: the high bits give the object, the low bits its triangle.
// With BuildPolicy::on_approach an object costs only its bounding box until the probe comes near. request_ahead (RT) then requests it,
// build_requested (a slow task, any thread) builds it, nearest first, and the next request_ahead with the probe outside its bounds
// activates it. An object activated around the probe would trap it, so it waits until the probe has left, unless the probe was placed
// there.
// RT: queries, place_probe and request_ahead yes; construction and build_requested set-up only.
// Threads: one for the RT side, one for build_requested.
class TouchGeometry {
 public:
  // The local frame is that of part_of, the box of a larger scene, or if that is empty, of the meshes' bounding box.
  // Pre: check(meshes, part_of) holds.
  explicit TouchGeometry(std::vector<std::shared_ptr<const TriangleMesh>> meshes, BuildPolicy policy = BuildPolicy::at_once,
                         std::optional<double> shading_crease_rad = std::nullopt, const Box& part_of = {});
  explicit TouchGeometry(const std::vector<const TriangleMesh*>& meshes);  // built at once; the meshes need not outlive this
  // Takes objects that were built in this frame, and may be shared. Triangles near another object stay walkable, so this is for contact
  // between meshes only. Pre: check() holds for the meshes of the objects, and no object has more triangles than most_triangles() of these.
  TouchGeometry(std::vector<std::shared_ptr<const ObjectGeometry>> objects, const LocalFrame& frame);
  // Takes objects that were built for a probe, and are shared: the result is as if they were built here, except for the frame. Pre: check()
  // holds for the meshes of the objects, and no object has more triangles than most_triangles() of these.
  explicit TouchGeometry(const BuiltObjects& built);

  // Error: more objects and triangles than can be numbered; with a part_of: it is not finite, or a mesh is not finite or not inside it.
  static Result<void> check(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes, const Box& part_of = {});
  // The local frame of a scene with that bounding box.
  static LocalFrame frame_of(const Box& bounds);
  // The local bounds of an object with these bounds in the scene, with a margin for rounding.
  static Box local_bounds(const LocalFrame& frame, const Box& bounds);
  // The most triangles that each object of a scene of these meshes may have, once its cracks are sealed (ObjectGeometry::make).
  static std::size_t most_triangles(const std::vector<std::shared_ptr<const TriangleMesh>>& meshes);

  const LocalFrame& frame() const { return frame_; }
  const Vec3& origin() const { return frame_.origin; }
  double unit_m() const { return frame_.unit_m; }
  Vec3 to_local(const Vec3& p_S) const { return (p_S - frame_.origin) * units_per_m_; }  // as frame().to_local(): powers of two are exact
  Vec3 to_scene(const Vec3& local) const { return frame_.to_scene(local); }

  std::size_t object_count() const { return slots_.size(); }
  std::size_t built_count() const { return finished_count_.load(std::memory_order_acquire); }
  std::size_t waiting_count() const { return waiting_count_; }  // objects that are not active yet
  std::size_t triangle_count() const;                           // of the objects built
  std::size_t bytes() const;                                    // of the objects built

  const Vec3& corner(std::uint32_t id, int k) const { return object(id).corner(id & triangle_mask_, k); }
  ObjectGeometry::Corners corners(std::uint32_t id) const { return object(id).corners(id & triangle_mask_); }
  Separation separation(std::uint32_t id, const Vec3& p) const { return object(id).separation(id & triangle_mask_, p); }
  std::uint32_t mesh_of(std::uint32_t id) const { return id >> triangle_bits_; }
  std::uint32_t triangle_of(std::uint32_t id) const { return id & triangle_mask_; }  // its index in the object
  // An object's own structures. Pre: it is built.
  const ObjectGeometry& object_geometry(std::uint32_t mesh) const {
    return slots_[mesh].shared ? *slots_[mesh].shared : *slots_[mesh].built;
  }
  // With BuildPolicy::to_deform: the object, and its number for each vertex of the mesh. While the object changes, nothing may use this.
  ObjectGeometry& deforming_object() { return *slots_[0].built; }
  const std::vector<std::uint32_t>& new_vertex() const { return new_vertex_; }
  std::uint32_t object_bits() const { return ~triangle_mask_; }  // the bits of a triangle's number that give the object
  // What is adjacent at edge k of a triangle, see SurfaceAdjacency.
  struct Adjacent {
    std::uint32_t id = 0;
    int edge = 0;
    bool flips = false;
    bool exists = false;
  };
  Adjacent adjacent(std::uint32_t id, int k) const {
    const SurfaceAdjacency::Adjacent across = object(id).adjacency().adjacent(id & triangle_mask_, k);
    return {(id & ~triangle_mask_) | across.triangle, across.edge, across.flips, across.exists};
  }
  bool is_in_large_fan(std::uint32_t id) const { return object(id).adjacency().is_in_large_fan(id & triangle_mask_); }
  // See SurfaceAdjacency. -1 if the surface deforms: whether a fan is convex is known only for the shape at rest.
  int convex_fan_corner(std::uint32_t id, bool back) const {
    return policy_ == BuildPolicy::to_deform ? -1 : object(id).adjacency().convex_fan_corner(id & triangle_mask_, back);
  }
  bool may_have_large_fans() const;  // also true while an object is not built: it may have some
  bool is_walkable(std::uint32_t id) const { return object(id).adjacency().is_walkable(id & triangle_mask_); }

  // Where a segment crosses a triangle, and from which side. Every decision is an exact sign (side_sign.h), so no segment passes between
  // two triangles that share an edge, nor does a chain of connected segments.
  struct Hit {
    double time = 2.0;  // 0 at p, 1 at q; above 1: no crossing
    bool from_back = false;
  };
  // RT: yes.
  Hit pierce(std::uint32_t id, const Vec3& p, const Vec3& q) const noexcept;

  // Calls until = visit(id, until) for triangles whose boxes come within `radius` of the segment from p to q before `until`, 1 at first.
  template <class Visit>
  void visit_along(const Vec3& p, const Vec3& q, double radius, Visit&& visit) const;

  Vec3 smooth_normal(std::uint32_t id, const Vec3& on_triangle) const noexcept {
    return object(id).smooth_normal(id & triangle_mask_, on_triangle);
  }
  void prefetch_indices(std::uint32_t id) const { object(id).prefetch_indices(id & triangle_mask_); }
  void prefetch_across(std::uint32_t id, int k) const { object(id).prefetch_across(id & triangle_mask_, k); }
  void prefetch_opposite(std::uint32_t id, int k) const { object(id).prefetch_opposite(id & triangle_mask_, k); }
  void prefetch_corners(std::uint32_t id) const { object(id).prefetch_corners(id & triangle_mask_); }

  // Calls visit(id) for every triangle whose box overlaps the query, and for some near it. If visit returns false, the search ends.
  template <class Visit>
  void for_each_overlapping(const Box& query, Visit&& visit) const;
  // The same for triangles whose boxes come within `radius` of p. Here visit must return a bool: false ends the search.
  template <class Visit>
  void for_each_within(const Vec3& p, double radius, Visit&& visit) const;

  // Calls bound_squared = visit(id, bound_squared) for triangles whose boxes may be nearer to p than sqrt(bound_squared).
  template <class Visit>
  void visit_nearest(const Vec3& p, double bound_squared, Visit&& visit) const;

  // The search of visit_nearest, one triangle at a time, so that it can be interrupted. RT: yes. Pre: the geometry neither deforms nor gets
  // another active object until it ends.
  class NearestSearch {
   public:
    void start(const Vec3& p) noexcept {
      p_ = p;
      is_in_object_ = false;
      objects_.start(p);
    }
    // The next triangle whose box may be nearer than sqrt(bound_squared). None: the search has ended.
    std::optional<std::uint32_t> next(const TouchGeometry& geometry, double bound_squared) noexcept;

   private:
    Vec3 p_ = Vec3::Zero();
    WideBvh::NearestSearch objects_;
    WideBvh::NearestSearch triangles_;  // of object_
    std::uint32_t object_ = 0;
    bool is_in_object_ = false;
  };

  // Places the probe at p: objects whose bounds enclose it are requested, and request_ahead() activates them as soon as they are built.
  void place_probe(const Vec3& p) noexcept;

  // Call before the probe at p moves. Requests objects that are not built and nearer than their own size or `range`, and activates those
  // that have been built and do not enclose p. Returns how far p may move before the next call is needed: 0 while a requested object is not
  // active, infinity if all are. A call within the distance that the previous one returned searches nothing.
  double request_ahead(const Vec3& p, double range) noexcept;

  // Builds one requested object. False if there is none.
  bool build_requested();

 private:
  struct Slot {
    std::shared_ptr<const TriangleMesh> mesh;      // used by the builder alone, once requested
    std::unique_ptr<ObjectGeometry> built;         // written by the builder, before the object counts as finished
    std::shared_ptr<const ObjectGeometry> shared;  // in place of `built`, if it was built elsewhere
    double size = 0.0;                             // the diagonal of its bounds
    bool is_requested = false;                     // of the RT side only, like the next member
    std::uint64_t placed_in = 0;                   // number of the last placement at which its bounds enclosed the probe
  };

  // Takes objects that were built elsewhere.
  TouchGeometry(std::vector<std::shared_ptr<const ObjectGeometry>> objects, std::span<const Box> bounds, const LocalFrame& frame,
                int triangle_bits);
  void mark_unwalkable_near_others(std::uint32_t object);
  // Shortens from..until to the part of the motion that may lie in the box.
  static void clip(const Box& box, const Vec3& p, const Vec3& motion, double& from, double& until) noexcept;
  const ObjectGeometry& object(std::uint32_t id) const { return *active_[id >> triangle_bits_]; }
  void request(std::uint32_t object) noexcept;
  void activate(const Vec3& p) noexcept;
  void find_unrequested(const Vec3& p, double range) noexcept;

  LocalFrame frame_;
  double units_per_m_ = 1.0;
  std::optional<double> shading_crease_rad_;
  BuildPolicy policy_ = BuildPolicy::at_once;
  std::vector<std::uint32_t> new_vertex_;
  int triangle_bits_ = 31;
  std::uint32_t triangle_mask_ = 0x7FFFFFFFU;
  ObjectHierarchy hierarchy_;                  // over local bounds, with a margin for rounding
  std::vector<const ObjectGeometry*> active_;  // one for each object; null until it is active
  std::vector<Slot> slots_;

  // With on_approach only. Each object is requested once and finished once, so the two lists between the threads cannot overflow.
  ObjectHierarchy approach_;  // over bounds grown by the object's own size
  std::vector<std::uint32_t> requested_;
  std::atomic<std::uint32_t> requested_count_ = 0;
  std::uint32_t next_request_ = 0;  // index into requested_; used by the builder only
  std::vector<std::uint32_t> finished_;
  std::atomic<std::uint32_t> finished_count_ = 0;
  std::uint32_t received_count_ = 0;      // index into finished_; of the RT side only, like all members below
  std::vector<std::uint32_t> enclosing_;  // objects that are finished but not active, because they enclose the probe
  std::size_t enclosing_count_ = 0;
  std::size_t waiting_count_ = 0;  // objects not active yet
  std::size_t active_count_ = 0;
  std::uint64_t placement_number_ = 0;
  Vec3 searched_from_ = Vec3::Zero();  // of the last search for unrequested objects: its position, its range, how far p may move from it
  double searched_range_ = 0.0;
  double unrequested_distance_ = 0.0;
};

// ---------------------------------------------------------------------------------------------------------------------

template <class Visit>
void TouchGeometry::visit_along(const Vec3& p, const Vec3& q, double radius, Visit&& visit) const {
  const Vec3 motion = q - p;
  hierarchy_.visit_along(p, motion, radius, 1.0, [&](std::uint32_t o, double until) {
    double begin = 0.0;
    double end = until;
    clip(hierarchy_.bounds(o).inflated(radius), p, motion, begin, end);
    if (active_[o] == nullptr || begin > end) return until;
    const std::uint32_t first_id = o << triangle_bits_;
    const double length = std::max(end - begin, 0x1p-60);
    active_[o]->tree().visit_along(p + begin * motion, (end - begin) * motion, radius, 1.0, [&](std::uint32_t t, double part_until) {
      const double before = until;
      until = visit(first_id | t, until);
      if (until < 0.0) return until;
      return until == before ? part_until : std::clamp((until - begin) / length * (1.0 + 0x1p-40) + 0x1p-40, 0.0, part_until);
    });
    return until;
  });
}

template <class Visit>
void TouchGeometry::for_each_overlapping(const Box& query, Visit&& visit) const {
  hierarchy_.for_each_overlapping(query, [&](std::uint32_t o) {
    bool goes_on = true;
    if (active_[o] == nullptr) return goes_on;
    const std::uint32_t first_id = o << triangle_bits_;
    active_[o]->tree().for_each_overlapping(query, [&](std::uint32_t t) {
      if constexpr (std::is_same_v<decltype(visit(t)), bool>) return goes_on = visit(first_id | t);
      visit(first_id | t);
      return true;
    });
    return goes_on;
  });
}

template <class Visit>
void TouchGeometry::for_each_within(const Vec3& p, double radius, Visit&& visit) const {
  hierarchy_.for_each_overlapping(Box{p, p}.inflated(radius), [&](std::uint32_t o) {
    bool goes_on = true;
    if (active_[o] == nullptr) return goes_on;
    const std::uint32_t first_id = o << triangle_bits_;
    active_[o]->tree().for_each_within(p, radius, [&](std::uint32_t t) { return goes_on = visit(first_id | t); });
    return goes_on;
  });
}

template <class Visit>
void TouchGeometry::visit_nearest(const Vec3& p, double bound_squared, Visit&& visit) const {
  hierarchy_.visit_nearest(p, bound_squared, [&](std::uint32_t o, double bound) {
    if (active_[o] == nullptr) return bound;
    const std::uint32_t first_id = o << triangle_bits_;
    active_[o]->tree().visit_nearest(p, bound, [&](std::uint32_t t, double) { return bound = visit(first_id | t, bound); });
    return bound;
  });
}

inline std::optional<std::uint32_t> TouchGeometry::NearestSearch::next(const TouchGeometry& geometry, double bound_squared) noexcept {
  for (;;) {
    if (is_in_object_) {
      if (const auto t = triangles_.next(geometry.active_[object_]->tree(), bound_squared)) return object_ << geometry.triangle_bits_ | *t;
      is_in_object_ = false;
    }
    const auto next = geometry.hierarchy_.next_nearest(objects_, bound_squared);
    if (!next) return std::nullopt;
    object_ = *next;
    is_in_object_ = geometry.active_[object_] != nullptr;
    if (is_in_object_) triangles_.start(p_);
  }
}

}  // namespace hapton
