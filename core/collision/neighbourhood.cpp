#include "core/collision/neighbourhood.h"

#include <bit>
#include <utility>

namespace hapton {
namespace {

__m256 dot(const __m256 u[3], const __m256 v[3]) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(u[0], v[0]), _mm256_mul_ps(u[1], v[1])), _mm256_mul_ps(u[2], v[2]));
}

void load(const float from[3][8], __m256 into[3]) {
  for (int k = 0; k < 3; ++k) into[k] = _mm256_load_ps(from[k]);
}

// off = from - clamp(from . edge / |edge|^2) edge: from the edge's nearest point to the query; its squared length is returned.
__m256 off_edge(const __m256 from[3], const __m256 edge[3], const __m256& inverse, __m256 off[3]) {
  __m256 t = _mm256_mul_ps(dot(from, edge), inverse);
  t = _mm256_min_ps(_mm256_max_ps(t, _mm256_setzero_ps()), _mm256_set1_ps(1.0F));
  for (int k = 0; k < 3; ++k) off[k] = _mm256_sub_ps(from[k], _mm256_mul_ps(t, edge[k]));
  return dot(off, off);
}

void cross(const __m256 u[3], const __m256 v[3], __m256 into[3]) {
  into[0] = _mm256_sub_ps(_mm256_mul_ps(u[1], v[2]), _mm256_mul_ps(u[2], v[1]));
  into[1] = _mm256_sub_ps(_mm256_mul_ps(u[2], v[0]), _mm256_mul_ps(u[0], v[2]));
  into[2] = _mm256_sub_ps(_mm256_mul_ps(u[0], v[1]), _mm256_mul_ps(u[1], v[0]));
}

void choose(const __m256& mask, const __m256 other[3], __m256 into[3]) {
  for (int k = 0; k < 3; ++k) into[k] = _mm256_blendv_ps(into[k], other[k], mask);
}

}  // namespace

Neighbourhood::Bound Neighbourhood::separation_bound(const Block& block, const __m256 p[3], const __m256 motion[3]) noexcept {
  __m256 a[3];
  __m256 ab[3];
  __m256 ac[3];
  __m256 ap[3];
  __m256 bp[3];
  __m256 bc[3];
  load(block.a, a);
  load(block.ab, ab);
  load(block.ac, ac);
  for (int k = 0; k < 3; ++k) {
    ap[k] = _mm256_sub_ps(p[k], a[k]);
    bp[k] = _mm256_sub_ps(ap[k], ab[k]);
    bc[k] = _mm256_sub_ps(ac[k], ab[k]);
  }
  __m256 off[3];
  __m256 other[3];
  __m256 best = off_edge(ap, ab, _mm256_load_ps(block.inverse_ab), off);
  __m256 squared = off_edge(ap, ac, _mm256_load_ps(block.inverse_ac), other);
  __m256 nearer = _mm256_cmp_ps(squared, best, _CMP_LT_OQ);
  choose(nearer, other, off);
  best = _mm256_min_ps(best, squared);
  squared = off_edge(bp, bc, _mm256_load_ps(block.inverse_bc), other);
  nearer = _mm256_cmp_ps(squared, best, _CMP_LT_OQ);
  choose(nearer, other, off);
  best = _mm256_min_ps(best, squared);

  // Inside the triangle's prism the face is nearest. The three side tests need only be about right.
  __m256 normal[3];
  load(block.unit_normal, normal);
  __m256 cross_ap[3];  // ap x normal: its dot with an edge tells the side
  cross(ap, normal, cross_ap);
  __m256 cross_bp[3];
  cross(bp, normal, cross_bp);
  const __m256 zero = _mm256_setzero_ps();
  __m256 inside = _mm256_cmp_ps(dot(cross_ap, ab), zero, _CMP_GT_OQ);
  inside = _mm256_and_ps(inside, _mm256_cmp_ps(dot(cross_bp, bc), zero, _CMP_GT_OQ));
  inside = _mm256_and_ps(inside, _mm256_cmp_ps(dot(cross_ap, ac), zero, _CMP_LT_OQ));
  const __m256 height = dot(ap, normal);
  const __m256 sign = _mm256_and_ps(height, _mm256_set1_ps(-0.0F));
  for (int k = 0; k < 3; ++k) other[k] = _mm256_xor_ps(normal[k], sign);
  // Unit direction u off the edges, or the normal inside.
  const __m256 length = _mm256_sqrt_ps(best);
  const __m256 inverse = _mm256_and_ps(_mm256_div_ps(_mm256_set1_ps(1.0F), length), _mm256_cmp_ps(best, zero, _CMP_GT_OQ));
  for (int k = 0; k < 3; ++k) off[k] = _mm256_mul_ps(off[k], inverse);
  choose(inside, other, off);

  // u . (q - x) for every x of the triangle is at least its value at the corner that lies farthest along u.
  const __m256 support = _mm256_max_ps(zero, _mm256_max_ps(dot(off, ab), dot(off, ac)));
  const __m256 distance = _mm256_sub_ps(_mm256_sub_ps(dot(off, ap), support), _mm256_load_ps(block.rounding));
  return {distance, _mm256_min_ps(zero, dot(off, motion))};
}

int Neighbourhood::find_meetings(const Vec3& p, const Vec3& motion, double radius, const Box& way,
                                 std::array<Meeting, kCapacity>& meetings) const noexcept {
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
  const __m256 enough = _mm256_set1_ps(detail::round_up(radius) + magnitude * 0x1p-20F);
  const __m256 zero = _mm256_setzero_ps();
  int n = 0;
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
    const Bound bound = separation_bound(block, start, move);
    const __m256 gap = _mm256_sub_ps(bound.distance, enough);
    hit = _mm256_andnot_ps(_mm256_cmp_ps(_mm256_add_ps(gap, bound.approach), zero, _CMP_GT_OQ), hit);
    auto mask = static_cast<unsigned>(_mm256_movemask_ps(hit));
    if (mask == 0) continue;
    // gap / -approach, rounded down by a few units; zero where the gap is closed already.
    const __m256 time = _mm256_mul_ps(_mm256_div_ps(gap, _mm256_sub_ps(zero, bound.approach)), _mm256_set1_ps(1.0F - 0x1p-21F));
    alignas(32) float earliest[8];
    _mm256_store_ps(earliest, _mm256_and_ps(time, _mm256_cmp_ps(gap, zero, _CMP_GT_OQ)));
    for (; mask != 0; mask &= mask - 1) {
      const int lane = std::countr_zero(mask);
      meetings[n] = {earliest[lane], block.triangle[lane], static_cast<std::uint32_t>(8 * b + lane)};
      if (meetings[n].earliest < meetings[0].earliest) std::swap(meetings[n], meetings[0]);
      ++n;
    }
  }
  return n;
}

// Three passes, so that the memory a triangle needs is on its way while others are worked on: numbers, corners, derived values.
bool Neighbourhood::fill(const TouchGeometry& geometry, const Box& region) noexcept {
  clear();
  center_ = region.center();
  geometry_ = &geometry;
  is_prepared_.reset();
  std::array<std::uint32_t, kCapacity> found;
  int n = 0;
  bool fits = true;
  geometry.for_each_overlapping(region, [&](std::uint32_t triangle) {
    if (n < kCapacity) {
      geometry.prefetch_indices(triangle);
      found[n++] = triangle;
    } else {
      fits = false;
    }
  });
  if (!fits) return false;
  for (int i = 0; i < n; ++i) geometry.prefetch_corners(found[i]);
  for (int i = 0; i < n; ++i) {
    Block& block = blocks_[i / 8];
    const int lane = i % 8;
    const Vec3& a = geometry.corner(found[i], 0);
    const Vec3& b = geometry.corner(found[i], 1);
    const Vec3& c = geometry.corner(found[i], 2);
    for (int k = 0; k < 3; ++k) {
      block.a[k][lane] = static_cast<float>(a[k] - center_[k]);
      block.ab[k][lane] = static_cast<float>(b[k] - a[k]);
      block.ac[k][lane] = static_cast<float>(c[k] - a[k]);
    }
    block.triangle[lane] = found[i];
  }
  for (int i = n; i % 8 != 0; ++i) {  // unused lanes: a point infinitely far away overlaps nothing
    for (int k = 0; k < 3; ++k) {
      blocks_[i / 8].a[k][i % 8] = std::numeric_limits<float>::infinity();
      blocks_[i / 8].ab[k][i % 8] = 0.0F;
      blocks_[i / 8].ac[k][i % 8] = 0.0F;
    }
  }
  for (int i = 0; i < n; i += 8) derive(blocks_[i / 8]);
  count_ = n;
  region_ = region;
  return true;
}

void Neighbourhood::derive(Block& block) noexcept {
  __m256 a[3];
  __m256 ab[3];
  __m256 ac[3];
  __m256 bc[3];
  load(block.a, a);
  load(block.ab, ab);
  load(block.ac, ac);
  const __m256 zero = _mm256_setzero_ps();
  const __m256 no_sign = _mm256_set1_ps(-0.0F);
  const auto magnitude = [&](const __m256& x) { return _mm256_andnot_ps(no_sign, x); };
  __m256 size = zero;
  for (int k = 0; k < 3; ++k) {
    bc[k] = _mm256_sub_ps(ac[k], ab[k]);
    size = _mm256_add_ps(size, _mm256_add_ps(magnitude(a[k]), _mm256_add_ps(magnitude(ab[k]), magnitude(ac[k]))));
  }
  const __m256 rounding = _mm256_mul_ps(size, _mm256_set1_ps(0x1p-19F));
  _mm256_store_ps(block.rounding, rounding);
  for (int k = 0; k < 3; ++k) {
    const __m256 least = _mm256_min_ps(zero, _mm256_min_ps(ab[k], ac[k]));
    const __m256 most = _mm256_max_ps(zero, _mm256_max_ps(ab[k], ac[k]));
    _mm256_store_ps(block.low[k], _mm256_sub_ps(_mm256_add_ps(a[k], least), rounding));
    _mm256_store_ps(block.high[k], _mm256_add_ps(_mm256_add_ps(a[k], most), rounding));
  }
  // A zero edge gets factor zero; an overflowing one too, which only weakens the bound.
  const auto inverse = [&](const __m256 edge[3]) {
    const __m256 squared = dot(edge, edge);
    return _mm256_and_ps(_mm256_div_ps(_mm256_set1_ps(1.0F), squared), _mm256_cmp_ps(squared, _mm256_set1_ps(1e-37F), _CMP_GT_OQ));
  };
  _mm256_store_ps(block.inverse_ab, inverse(ab));
  _mm256_store_ps(block.inverse_ac, inverse(ac));
  _mm256_store_ps(block.inverse_bc, inverse(bc));
  __m256 normal[3];
  cross(ab, ac, normal);
  const __m256 squared = dot(normal, normal);
  const __m256 has_area = _mm256_cmp_ps(squared, _mm256_set1_ps(1e-37F), _CMP_GT_OQ);
  const __m256 scale = _mm256_and_ps(_mm256_div_ps(_mm256_set1_ps(1.0F), _mm256_sqrt_ps(squared)), has_area);
  for (int k = 0; k < 3; ++k) _mm256_store_ps(block.unit_normal[k], _mm256_mul_ps(normal[k], scale));
}

}  // namespace hapton
