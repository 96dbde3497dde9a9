#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/collision/object_geometry.h"

namespace hapton {

// When the structures of an object are built: all at once, or each when the probe first comes near.
enum class BuildPolicy : std::uint8_t { at_once, on_approach };

// All triangles of a scene for contact queries, object by object, in one local frame.
//
// Triangles are numbered across objects: the object in the high bits, its triangle in the low ones.
// With BuildPolicy::on_approach an object costs its bounding box until the probe comes near: look_ahead (RT) asks for it, build_wanted (a
// slow task, any thread) builds it, and from the next look_ahead with the probe outside its bounds it can be touched. An object that
// appeared round the probe would trap it, so it waits until the probe has left, unless the probe was placed there.
// RT: queries and look_ahead yes; construction and build_wanted set-up only.
// Threads: one for the RT side, one for build_wanted.
class TouchGeometry {
 public:
  explicit TouchGeometry(std::vector<std::shared_ptr<const TriangleMesh>> meshes, BuildPolicy policy = BuildPolicy::at_once,
                         std::optional<double> shading_crease_rad = std::nullopt);
  explicit TouchGeometry(const std::vector<const TriangleMesh*>& meshes);  // built at once; the meshes may go afterwards

  const LocalFrame& frame() const { return frame_; }
  const Vec3& origin() const { return frame_.origin; }
  double unit_m() const { return frame_.unit_m; }
  Vec3 to_local(const Vec3& p_S) const { return (p_S - frame_.origin) * units_per_m_; }  // as the frame's: powers of two are exact
  Vec3 to_scene(const Vec3& local) const { return frame_.to_scene(local); }

  std::size_t object_count() const { return slots_.size(); }
  std::size_t built_count() const;
  std::size_t waiting_count() const { return waiting_; }  // objects that cannot be touched yet
  std::size_t triangle_count() const;                     // of the objects built
  std::size_t bytes() const;                              // of the objects built

  const Vec3& corner(std::uint32_t id, int k) const { return object(id).corner(id & triangle_mask_, k); }
  ObjectGeometry::Corners corners(std::uint32_t id) const { return object(id).corners(id & triangle_mask_); }
  Separation separation(std::uint32_t id, const Vec3& p) const { return object(id).separation(id & triangle_mask_, p); }
  std::uint32_t mesh_of(std::uint32_t id) const { return id >> triangle_bits_; }
  std::uint32_t object_bits() const { return ~triangle_mask_; }  // of a triangle's number: alike in two, they are of one object
  // Side k of a triangle is across its edge k, see SurfaceAdjacency.
  struct Across {
    std::uint32_t id = 0;
    int edge = 0;
    bool flips = false;
    bool exists = false;
  };
  Across across(std::uint32_t id, int k) const {
    const SurfaceAdjacency::Across across = object(id).adjacency().across(id & triangle_mask_, k);
    return {(id & ~triangle_mask_) | across.triangle, across.edge, across.flips, across.exists};
  }
  bool is_walkable(std::uint32_t id) const { return object(id).adjacency().is_walkable(id & triangle_mask_); }

  // Where a segment goes through a triangle, and from which side. Every decision is an exact sign (side_sign.h), so no segment passes between
  // two triangles that share an edge, nor does a chain of segments each of which begins where the one before ended.
  struct Hit {
    double time = 2.0;  // 0 at p, 1 at q; above 1: it is not met
    bool from_back = false;
  };
  // RT: yes.
  Hit pierce(std::uint32_t id, const Vec3& p, const Vec3& q) const noexcept;

  // Calls until = visit(id, until) for triangles whose boxes come within `radius` of the segment from p to q before the time `until`.
  template <class Visit>
  void visit_along(const Vec3& p, const Vec3& q, double radius, Visit&& visit) const {
    double until = 1.0;
    const Vec3 motion = q - p;
    const Box way = Box::around(p, q).inflated(radius);
    for (const Slot& slot : slots_) {
      if (slot.active == nullptr || !slot.bounds.overlaps(way)) continue;
      double begin = 0.0;
      double end = until;
      clip(slot.bounds.inflated(radius), p, motion, begin, end);
      if (begin > end) continue;
      slot.active->tree().visit_along(p + begin * motion, (end - begin) * motion, radius, 1.0, [&](std::uint32_t t, double part_until) {
        const double before = until;
        until = visit(slot.first_id | t, until);
        if (until == before) return part_until;
        return std::clamp((until - begin) / std::max(end - begin, 0x1p-60) * (1.0 + 0x1p-40) + 0x1p-40, 0.0, part_until);
      });
    }
  }

  Vec3 smooth_normal(std::uint32_t id, const Vec3& on_triangle) const noexcept {
    return object(id).smooth_normal(id & triangle_mask_, on_triangle);
  }
  void prefetch_indices(std::uint32_t id) const { object(id).prefetch_indices(id & triangle_mask_); }
  void prefetch_corners(std::uint32_t id) const { object(id).prefetch_corners(id & triangle_mask_); }

  // Calls visit(id) for every triangle whose box overlaps the query, and some that only nearly do. A visit that returns a bool ends the
  // search within an object by false.
  template <class Visit>
  void for_each_overlapping(const Box& query, Visit&& visit) const {
    for (const Slot& slot : slots_) {
      if (slot.active == nullptr || !slot.bounds.overlaps(query)) continue;
      slot.active->tree().for_each_overlapping(query, [&](std::uint32_t t) { return visit(slot.first_id | t); });
    }
  }

  // Calls bound_squared = visit(id, bound_squared) for triangles whose boxes may lie nearer to p than sqrt(bound_squared).
  template <class Visit>
  void visit_nearest(const Vec3& p, double bound_squared, Visit&& visit) const {
    for (const Slot& slot : slots_) {
      if (slot.active == nullptr || distance_squared(slot.bounds, p) >= bound_squared) continue;
      slot.active->tree().visit_nearest(p, bound_squared,
                                        [&](std::uint32_t t, double) { return bound_squared = visit(slot.first_id | t, bound_squared); });
    }
  }

  // The probe is put at p: objects whose bounds enclose it are asked for and come in as soon as they are built, as if they had always been.
  void place(const Vec3& p) noexcept;

  // Before the probe at p moves: asks for objects that are not built and lie nearer than their own size or `reach`, and lets those in
  // that have been built and do not enclose p. Returns how far p may go before this must be called again; infinity when all are in.
  double look_ahead(const Vec3& p, double reach) noexcept;

  // Builds one object that was asked for. False when there is none.
  bool build_wanted();

 private:
  struct Slot {
    std::shared_ptr<const TriangleMesh> mesh;
    Box bounds;  // local, with a margin for rounding
    std::uint32_t first_id = 0;
    std::unique_ptr<ObjectGeometry> built;  // written by the builder, before ready
    std::atomic<bool> wanted = false;
    std::atomic<const ObjectGeometry*> ready = nullptr;
    const ObjectGeometry* active = nullptr;  // RT side only, like the next
    bool encloses_start = false;
  };

  void mark_unwalkable_between_objects();
  // Shortens from..until to the part of the motion that may lie in the box.
  static void clip(const Box& box, const Vec3& p, const Vec3& motion, double& from, double& until) noexcept;

  static double distance_squared(const Box& box, const Vec3& p) { return (box.low - p).cwiseMax(p - box.high).cwiseMax(0.0).squaredNorm(); }
  const ObjectGeometry& object(std::uint32_t id) const { return *slots_[id >> triangle_bits_].active; }

  LocalFrame frame_;
  double units_per_m_ = 1.0;
  std::optional<double> shading_crease_rad_;
  std::vector<Slot> slots_;
  int triangle_bits_ = 31;
  std::uint32_t triangle_mask_ = 0x7FFFFFFFU;
  std::size_t waiting_ = 0;  // objects not active yet
};

}  // namespace hapton
