#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <memory>
#include <span>

#include "core/collision/touch_geometry.h"
#include "core/geometry/contact_triangle.h"
#include "core/math/float8.h"

namespace hapton {

// The triangles near a probe, copied into vector lanes in single precision: a sweep near them costs a few vector instructions per eight
// triangles and no tree traversal. Every triangle that overlaps the cached region is in the cache, so a sweep whose box lies inside the
// region needs nothing else. The filters are conservative: they may let a triangle through that is not touched but never drop one that is;
// exact tests in double precision follow.
// RT: yes (fixed capacity; rebuild reports failure instead of dropping triangles).
class TriangleCache {
 public:
  static constexpr int kCapacity = 256;
  static constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;

  // Copies all triangles that overlap `region`; the geometry must stay valid while shape() is called. Returns false, with an empty cache,
  // if there are more than kCapacity.
  bool rebuild(const TouchGeometry& geometry, const Box& region) noexcept;

  // The same in three parts, so that memory is prefetched while something else runs: which triangles, their corners, the copy. The old
  // content stays valid until commit(). query: false if there are too many.
  bool query(const TouchGeometry& geometry, const Box& region) noexcept;
  void fetch() const noexcept;
  void commit() noexcept;
  bool will_cover(const Box& box) const { return lies_in(box, wanted_); }

  void clear() noexcept {
    count_ = 0;
    found_count_ = 0;
    region_ = Box();
    wanted_ = Box();
  }
  int count() const { return count_; }

  // The triangle in a slot, in double precision; prepared at the first call.
  const ContactTriangle& shape(std::uint32_t slot) noexcept {
    if (!is_prepared_[slot]) {
      const std::uint32_t triangle = triangle_at(slot);
      const ObjectGeometry::Corners corners = geometry_->corners(triangle);
      std::construct_at(&shapes_[slot], corners.a, corners.b, corners.c);
      is_prepared_.set(slot);
    }
    return shapes_[slot];
  }

  // The slot of a cached triangle, or kNoSlot. `hint`: its last known slot, tried first.
  std::uint32_t slot_of(std::uint32_t triangle, std::uint32_t hint = kNoSlot) const noexcept;

  // The triangle at the other side of an edge.
  struct Adjacent {
    std::uint32_t slot = kNoSlot;   // of the only other cached triangle with both vertices of the edge; kNoSlot: none, or several
    std::int16_t edge = 0;          // its own number of the edge
    bool same_orientation = false;  // it runs along the edge the other way, as in a consistently oriented mesh
  };
  // Edge k of the triangle in `slot` runs from its corner k to the next. Pre: the edge overlaps the cached region.
  Adjacent adjacent(std::uint32_t slot, int k) const noexcept;

  // The number of cached triangles with the vertex that is corner k of the one in `slot`.
  int count_at_vertex(std::uint32_t slot, int k) const noexcept;

  std::uint32_t triangle_at(std::uint32_t slot) const { return blocks_[slot / 8].triangle[slot % 8]; }

  bool covers(const Box& box) const { return lies_in(box, region_); }

  // The share of the motion from p during which a sphere of radius `radius` stays inside the region; may exceed 1.
  double time_inside(const Vec3& p, const Vec3& motion, double radius) const {
    double t = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      if (motion[k] > 0.0) t = std::min(t, (region_.high[k] - radius - p[k]) / motion[k]);
      if (motion[k] < 0.0) t = std::min(t, (region_.low[k] + radius - p[k]) / motion[k]);
    }
    return std::max(t, 0.0);
  }

  // True if certainly no triangle except those in the slots `except` is nearer than `radius` to the polyline `path`. A triangle is clear of
  // the path if its plane, or a plane through one of its edges, separates it from the whole polyline; otherwise the result is false. Pre:
  // covers the polyline's box, inflated.
  bool is_clear(std::span<const Vec3> path, double radius, std::span<const std::uint32_t> except) const noexcept;

  // A triangle that a moving sphere may hit, not before the time `earliest` (0..1).
  struct Candidate {
    float earliest;
    std::uint32_t triangle;
    std::uint32_t slot;  // for shape()
  };

  // Lists every triangle to which a sphere of radius `radius`, moving from p along `motion`, may come nearer than its radius; the one with
  // the earliest time comes first, the others in no order. `path` is the box of that motion, inflated by the radius. Returns their number.
  // Pre: covers(path), up to rounding.
  int find_candidates(const Vec3& p, const Vec3& motion, double radius, const Box& path,
                      std::array<Candidate, kCapacity>& candidates) const noexcept;

 private:
  // Eight triangles: corner a and edges ab, ac relative to centre_, their boxes, and a bound on the rounding of all of these.
  struct alignas(32) Block {
    float low[3][8];
    float high[3][8];
    float a[3][8];
    float ab[3][8];
    float ac[3][8];
    float unit_normal[3][8];  // zero for a degenerate triangle
    float side[3][3][8];      // perpendicular to edge k, towards the inside; unit or zero
    float side_from[3][8];    // smallest coordinate of the triangle along side[k]; plane_from and plane_to: range along the normal
    float plane_from[8];
    float plane_to[8];
    float inverse_ab[8];  // 1 / |ab|^2, zero for a zero edge
    float inverse_ac[8];
    float inverse_bc[8];
    float rounding[8];           // of any coordinate of this triangle
    std::uint32_t triangle[8];   // kNoSlot in unused lanes, like the next
    std::uint32_t vertex[3][8];  // indices of the corners in their object
  };

  static bool lies_in(const Box& box, const Box& region) {
    return (box.low.array() >= region.low.array()).all() && (box.high.array() <= region.high.array()).all();
  }
  void copy(std::span<const std::uint32_t> triangles, Block& block) const noexcept;
  static void derive(Block& block) noexcept;
  unsigned of_object(const Block& block, std::uint32_t triangle) const noexcept;
  static unsigned overlapping(const Block& block, const Float8 low[3], const Float8 high[3]) noexcept;

  // Per lane, from one separating direction (from the triangle's closest point to p): at time t the moving point is at least distance + t *
  // approach away. A wrong direction only weakens the bound.
  struct Bound {
    Float8 distance;
    Float8 approach;  // <= 0
  };
  static Bound separation_bound(const Block& block, const Float8 p[3], const Float8 motion[3]) noexcept;

  const TouchGeometry* geometry_ = nullptr;
  std::array<ContactTriangle, kCapacity> shapes_;
  std::bitset<kCapacity> is_prepared_;
  std::array<Block, kCapacity / 8> blocks_;
  int count_ = 0;
  Box region_;
  Vec3 centre_ = Vec3::Zero();
  std::array<std::uint32_t, kCapacity> found_;  // by query, in wanted_
  int found_count_ = 0;
  Box wanted_;
};

}  // namespace hapton
