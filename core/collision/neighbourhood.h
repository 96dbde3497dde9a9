#pragma once

#include <array>
#include <bit>
#include <cstdint>

#include "core/collision/touch_geometry.h"

namespace hapton {

// The triangles near a probe, copied side by side in single precision: a sweep near them costs a few vector instructions per
// eight triangles and touches no tree. Complete inside region(): every triangle that overlaps the region is here, so a sweep
// whose box lies inside needs nothing else. The filters are conservative: they may let a triangle through that is not touched,
// never drop one that is; exact tests follow in double precision.
// RT: yes (fixed capacity; fill reports instead of dropping).
class Neighbourhood {
 public:
  static constexpr int kCapacity = 256;

  // Copies all triangles that overlap `region`. False, and empty, when there are more than kCapacity of them.
  bool fill(const TouchGeometry& geometry, const Box& region) noexcept;

  void clear() noexcept { count_ = 0; region_ = Box(); }
  int count() const { return count_; }
  bool covers(const Box& box) const {
    return (box.low.array() >= region_.low.array()).all() && (box.high.array() <= region_.high.array()).all();
  }

  // Calls visit(triangle) for every triangle that a sphere of radius `radius`, moving from p along `motion`, may come nearer than
  // its radius to. `way` is the box of that motion, inflated by the radius. Pre: covers(way).
  template <class Visit>
  void for_each_in_way(const Vec3& p, const Vec3& motion, double radius, const Box& way, Visit&& visit) const noexcept;

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

  // A lower bound per lane on the distance between the moving point and the triangle, by one separating direction each: the
  // direction from the nearest point at the start. A wrong direction only weakens the bound.
  static __m256 separation_bound(const Block& block, const __m256 p[3], const __m256 motion[3]) noexcept;

  std::array<Block, kCapacity / 8> blocks_;
  int count_ = 0;
  Box region_;
  Vec3 center_ = Vec3::Zero();
};

template <class Visit>
void Neighbourhood::for_each_in_way(const Vec3& p, const Vec3& motion, double radius, const Box& way, Visit&& visit) const noexcept {
  __m256 low[3];
  __m256 high[3];
  __m256 start[3];
  __m256 move[3];
  float magnitude = 0.0F;
  for (int k = 0; k < 3; ++k) {
    low[k] = _mm256_set1_ps(detail::round_down(way.low[k] - center_[k]));
    high[k] = _mm256_set1_ps(detail::round_up(way.high[k] - center_[k]));
    const auto s = static_cast<float>(p[k] - center_[k]);
    const auto m = static_cast<float>(motion[k]);
    start[k] = _mm256_set1_ps(s);
    move[k] = _mm256_set1_ps(m);
    magnitude += std::fabs(s) + std::fabs(m);
  }
  // Rounding of the query's side of the bound: a dozen operations on values below `magnitude`.
  const __m256 enough = _mm256_set1_ps(detail::round_up(radius) * (1.0F + 0x1p-22F) + magnitude * 0x1p-20F);
  const int blocks = (count_ + 7) / 8;
  for (int b = 0; b < blocks; ++b) {
    const Block& block = blocks_[b];
    __m256 hit = _mm256_cmp_ps(_mm256_load_ps(block.low[0]), high[0], _CMP_LE_OQ);
    hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.high[0]), low[0], _CMP_GE_OQ));
    hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.low[1]), high[1], _CMP_LE_OQ));
    hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.high[1]), low[1], _CMP_GE_OQ));
    hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.low[2]), high[2], _CMP_LE_OQ));
    hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.high[2]), low[2], _CMP_GE_OQ));
    if (_mm256_testz_ps(hit, hit) != 0) continue;
    const __m256 bound = separation_bound(block, start, move);
    hit = _mm256_andnot_ps(_mm256_cmp_ps(bound, enough, _CMP_GT_OQ), hit);
    for (auto mask = static_cast<unsigned>(_mm256_movemask_ps(hit)); mask != 0; mask &= mask - 1) visit(block.triangle[std::countr_zero(mask)]);
  }
}

}  // namespace hapton
