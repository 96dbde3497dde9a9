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

// The triangles near a probe, copied side by side in single precision: a sweep near them costs a few vector instructions per
// eight triangles and touches no tree. Complete inside region(): every triangle that overlaps the region is here, so a sweep
// whose box lies inside needs nothing else. The filters are conservative: they may let a triangle through that is not touched,
// never drop one that is; exact tests follow in double precision.
// RT: yes (fixed capacity; fill reports instead of dropping).
class Neighbourhood {
 public:
  static constexpr int kCapacity = 256;
  static constexpr std::uint32_t kNowhere = 0xFFFFFFFFU;

  // Copies all triangles that overlap `region`; the geometry must stay while shape() is called. False, and empty, when there are more than
  // kCapacity of them.
  bool fill(const TouchGeometry& geometry, const Box& region) noexcept;

  // The same in three parts, so that the memory each needs is on its way while something else is done: which triangles, their corners, the
  // copy. Until take() what was here stays. look_for: false when there are too many.
  bool look_for(const TouchGeometry& geometry, const Box& region) noexcept;
  void fetch() const noexcept;
  void take() noexcept;
  bool will_cover(const Box& box) const { return lies_in(box, wanted_); }

  void clear() noexcept {
    count_ = 0;
    found_count_ = 0;
    region_ = Box();
    wanted_ = Box();
  }
  int count() const { return count_; }

  // The triangle at a place, in double precision and prepared; prepared when first asked for.
  const ContactTriangle& shape(std::uint32_t place) noexcept {
    if (!is_prepared_[place]) {
      const std::uint32_t triangle = triangle_at(place);
      const ObjectGeometry::Corners corners = geometry_->corners(triangle);
      std::construct_at(&shapes_[place], corners.a, corners.b, corners.c);
      is_prepared_.set(place);
    }
    return shapes_[place];
  }

  // The place of a triangle that is here, or kNowhere. `perhaps`: where it was before, looked at first.
  std::uint32_t place_of(std::uint32_t triangle, std::uint32_t perhaps = kNowhere) const noexcept;

  // What lies across an edge.
  struct Across {
    std::uint32_t place = kNowhere;  // of the one other triangle here with both the edge's vertices; kNowhere: there is none, or several
    std::int16_t edge = 0;           // its own name for the edge
    bool same_winding = false;       // it runs along the edge the other way, as in a consistently wound mesh
  };
  // Edge k of the triangle at `place` runs from its corner k to the next. Pre: the edge overlaps region().
  Across across(std::uint32_t place, int k) const noexcept;

  // How many triangles here have the vertex that is corner k of the one at `place`.
  int count_round(std::uint32_t place, int k) const noexcept;

  std::uint32_t triangle_at(std::uint32_t place) const { return blocks_[place / 8].triangle[place % 8]; }

  bool covers(const Box& box) const { return lies_in(box, region_); }

  // How much of the motion from p a sphere of radius `radius` stays inside the region, as a part of it; may exceed 1.
  double time_inside(const Vec3& p, const Vec3& motion, double radius) const {
    double t = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      if (motion[k] > 0.0) t = std::min(t, (region_.high[k] - radius - p[k]) / motion[k]);
      if (motion[k] < 0.0) t = std::min(t, (region_.low[k] + radius - p[k]) / motion[k]);
    }
    return std::max(t, 0.0);
  }

  // True when surely no triangle but those at the places `except` comes nearer than `radius` to the polyline `way`. What a plane through
  // one of a triangle's edges, or its own, does not part from the whole polyline is in doubt: false. Pre: covers the polyline's box,
  // inflated.
  bool is_clear(std::span<const Vec3> way, double radius, std::span<const std::uint32_t> except) const noexcept;

  // A triangle that a moving sphere may meet, not before `earliest` (of the motion's 0..1).
  struct Meeting {
    float earliest;
    std::uint32_t triangle;
    std::uint32_t place;  // for shape()
  };

  // Lists every triangle that a sphere of radius `radius`, moving from p along `motion`, may come nearer than its radius to; the
  // one that may be met first comes first, the others in no order. `way` is the box of that motion, inflated by the radius.
  // Returns their number. Pre: covers(way), up to rounding.
  int find_meetings(const Vec3& p, const Vec3& motion, double radius, const Box& way,
                    std::array<Meeting, kCapacity>& meetings) const noexcept;

 private:
  // Eight triangles: corner a and edges ab, ac relative to centre_, their boxes, and a bound on the rounding of all of it.
  struct alignas(32) Block {
    float low[3][8];
    float high[3][8];
    float a[3][8];
    float ab[3][8];
    float ac[3][8];
    float unit_normal[3][8];  // zero for a triangle without area
    float side[3][3][8];      // across edge k towards the inside, unit or zero
    float side_from[3][8];    // no point of the triangle has less along side[k], or along the normal, nor more than plane_to along that
    float plane_from[8];
    float plane_to[8];
    float inverse_ab[8];  // 1 / |ab|^2, zero for a zero edge
    float inverse_ac[8];
    float inverse_bc[8];
    float rounding[8];           // of any coordinate of this triangle, as float
    std::uint32_t triangle[8];   // kNowhere in unused lanes, like the next
    std::uint32_t vertex[3][8];  // the corners' numbers in their object
  };

  static bool lies_in(const Box& box, const Box& region) {
    return (box.low.array() >= region.low.array()).all() && (box.high.array() <= region.high.array()).all();
  }
  void copy(std::span<const std::uint32_t> triangles, Block& block) const noexcept;
  static void derive(Block& block) noexcept;
  unsigned of_object(const Block& block, std::uint32_t triangle) const noexcept;
  static unsigned overlapping(const Block& block, const Float8 low[3], const Float8 high[3]) noexcept;

  // Per lane, from one separating direction (from the triangle's nearest point to the point p): the moving point is at least
  // `distance` + t * `approach` away at time t. A wrong direction only weakens the bound.
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
  std::array<std::uint32_t, kCapacity> found_;  // by look_for, in wanted_
  int found_count_ = 0;
  Box wanted_;
};

}  // namespace hapton
