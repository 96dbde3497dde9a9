#pragma once

#include <array>
#include <bitset>
#include <cstdint>

#include "core/collision/touch_geometry.h"
#include "core/geometry/contact_triangle.h"

namespace hapton {

// The triangles near a probe, copied side by side in single precision: a sweep near them costs a few vector instructions per
// eight triangles and touches no tree. Complete inside region(): every triangle that overlaps the region is here, so a sweep
// whose box lies inside needs nothing else. The filters are conservative: they may let a triangle through that is not touched,
// never drop one that is; exact tests follow in double precision.
// RT: yes (fixed capacity; fill reports instead of dropping).
class Neighbourhood {
 public:
  static constexpr int kCapacity = 256;

  // Copies all triangles that overlap `region`; the geometry must stay while shape() is called. False, and empty, when there are more than
  // kCapacity of them.
  bool fill(const TouchGeometry& geometry, const Box& region) noexcept;

  void clear() noexcept {
    count_ = 0;
    region_ = Box();
  }
  int count() const { return count_; }

  // The triangle at a place, in double precision and prepared; prepared when first asked for.
  const ContactTriangle& shape(std::uint32_t place) noexcept {
    if (!is_prepared_[place]) {
      const std::uint32_t triangle = blocks_[place / 8].triangle[place % 8];
      shapes_[place] = ContactTriangle(geometry_->corner(triangle, 0), geometry_->corner(triangle, 1), geometry_->corner(triangle, 2));
      is_prepared_.set(place);
    }
    return shapes_[place];
  }

  bool covers(const Box& box) const {
    return (box.low.array() >= region_.low.array()).all() && (box.high.array() <= region_.high.array()).all();
  }

  // How much of the motion from p a sphere of radius `radius` stays inside the region, as a part of it; may exceed 1.
  double time_inside(const Vec3& p, const Vec3& motion, double radius) const {
    double t = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      if (motion[k] > 0.0) t = std::min(t, (region_.high[k] - radius - p[k]) / motion[k]);
      if (motion[k] < 0.0) t = std::min(t, (region_.low[k] + radius - p[k]) / motion[k]);
    }
    return std::max(t, 0.0);
  }

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
  // Eight triangles: corner a and edges ab, ac relative to center_, their boxes, and a bound on the rounding of all of it.
  struct alignas(32) Block {
    float low[3][8];
    float high[3][8];
    float a[3][8];
    float ab[3][8];
    float ac[3][8];
    float unit_normal[3][8];  // zero for a triangle without area
    float inverse_ab[8];      // 1 / |ab|^2, zero for a zero edge
    float inverse_ac[8];
    float inverse_bc[8];
    float rounding[8];  // of any coordinate of this triangle, as float
    std::uint32_t triangle[8];
  };

  static void derive(Block& block) noexcept;

  // Per lane, from one separating direction (from the triangle's nearest point to the point p): the moving point is at least
  // `distance` + t * `approach` away at time t. A wrong direction only weakens the bound.
  struct Bound {
    __m256 distance;
    __m256 approach;  // <= 0
  };
  static Bound separation_bound(const Block& block, const __m256 p[3], const __m256 motion[3]) noexcept;

  const TouchGeometry* geometry_ = nullptr;
  std::array<ContactTriangle, kCapacity> shapes_;
  std::bitset<kCapacity> is_prepared_;
  std::array<Block, kCapacity / 8> blocks_;
  int count_ = 0;
  Box region_;
  Vec3 center_ = Vec3::Zero();
};

}  // namespace hapton
