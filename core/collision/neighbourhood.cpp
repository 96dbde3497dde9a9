#include "core/collision/neighbourhood.h"

#include <bit>
#include <utility>

namespace hapton {
namespace {

__m256 dot(const __m256 u[3], const __m256 v[3]) {
  return _mm256_add_ps(_mm256_add_ps(_mm256_mul_ps(u[0], v[0]), _mm256_mul_ps(u[1], v[1])), _mm256_mul_ps(u[2], v[2]));
}

__m256 dot(const float u[3][8], const __m256 v[3]) {
  const __m256 xy = _mm256_add_ps(_mm256_mul_ps(_mm256_load_ps(u[0]), v[0]), _mm256_mul_ps(_mm256_load_ps(u[1]), v[1]));
  return _mm256_add_ps(xy, _mm256_mul_ps(_mm256_load_ps(u[2]), v[2]));
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

// Eight points to eight of each coordinate.
void turn(const __m128 points[8], float into[3][8]) {
  for (int half = 0; half < 8; half += 4) {
    __m128 x = points[half];
    __m128 y = points[half + 1];
    __m128 z = points[half + 2];
    __m128 w = points[half + 3];
    _MM_TRANSPOSE4_PS(x, y, z, w);
    _mm_store_ps(&into[0][half], x);
    _mm_store_ps(&into[1][half], y);
    _mm_store_ps(&into[2][half], z);
  }
}

__m256i load(const std::uint32_t from[8]) { return _mm256_load_si256(reinterpret_cast<const __m256i*>(from)); }

__m256i all_equal_to(std::uint32_t value) { return _mm256_set1_epi32(static_cast<int>(value)); }

unsigned lanes(const __m256i& mask) { return static_cast<unsigned>(_mm256_movemask_ps(_mm256_castsi256_ps(mask))); }

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

// Of a block's lanes, those whose boxes overlap.
unsigned Neighbourhood::overlapping(const Block& block, const __m256 low[3], const __m256 high[3]) noexcept {
  __m256 hit = _mm256_cmp_ps(_mm256_load_ps(block.low[0]), high[0], _CMP_LE_OQ);
  hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.high[0]), low[0], _CMP_GE_OQ));
  for (int k = 1; k < 3; ++k) {
    hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.low[k]), high[k], _CMP_LE_OQ));
    hit = _mm256_and_ps(hit, _mm256_cmp_ps(_mm256_load_ps(block.high[k]), low[k], _CMP_GE_OQ));
  }
  return static_cast<unsigned>(_mm256_movemask_ps(hit));
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
    const unsigned near = overlapping(block, low, high);
    if (near == 0) continue;
    const Bound bound = separation_bound(block, start, move);
    const __m256 gap = _mm256_sub_ps(bound.distance, enough);
    const __m256 misses = _mm256_cmp_ps(_mm256_add_ps(gap, bound.approach), zero, _CMP_GT_OQ);
    unsigned mask = near & ~static_cast<unsigned>(_mm256_movemask_ps(misses));
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

bool Neighbourhood::is_clear(std::span<const Vec3> way, double radius, std::span<const std::uint32_t> except) const noexcept {
  constexpr std::size_t kMostPoints = 32;
  if (way.size() > kMostPoints) return false;
  std::array<std::uint8_t, kCapacity / 8> excepted = {};
  for (const std::uint32_t place : except) excepted[place / 8] |= static_cast<std::uint8_t>(1U << (place % 8));
  std::array<std::array<float, 3>, kMostPoints> points;
  std::array<float, 3> least = {};
  std::array<float, 3> most = {};
  float magnitude = 0.0F;
  for (std::size_t i = 0; i < way.size(); ++i) {
    float size = 0.0F;
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<float>(way[i][k] - center_[k]);
      points[i][k] = x;
      least[k] = i == 0 ? x : std::min(least[k], x);
      most[k] = i == 0 ? x : std::max(most[k], x);
      size += std::fabs(x);
    }
    magnitude = std::max(magnitude, size);
  }
  const float enough = detail::round_up(radius) + magnitude * 0x1p-20F;
  __m256 low[3];
  __m256 high[3];
  for (int k = 0; k < 3; ++k) {
    low[k] = _mm256_set1_ps(least[k] - enough);
    high[k] = _mm256_set1_ps(most[k] + enough);
  }
  const __m256 apart = _mm256_set1_ps(enough);
  // First which blocks have to be looked at, then those: no processor can guess which.
  std::array<int, kCapacity / 8> at;
  std::array<unsigned, kCapacity / 8> near;
  int count = 0;
  const int blocks = (count_ + 7) / 8;
  for (int b = 0; b < blocks; ++b) {
    at[count] = b;
    near[count] = overlapping(blocks_[b], low, high) & ~static_cast<unsigned>(excepted[b]);
    count += near[count] != 0 ? 1 : 0;
  }
  for (int n = 0; n < count; ++n) {
    const Block& block = blocks_[at[n]];
    __m256 side_most[3];  // over the polyline
    __m256 plane_least;
    __m256 plane_most;
    for (std::size_t i = 0; i < way.size(); ++i) {
      const __m256 p[3] = {_mm256_set1_ps(points[i][0]), _mm256_set1_ps(points[i][1]), _mm256_set1_ps(points[i][2])};
      for (int k = 0; k < 3; ++k) {
        const __m256 along = dot(block.side[k], p);
        side_most[k] = i == 0 ? along : _mm256_max_ps(side_most[k], along);
      }
      const __m256 along = dot(block.unit_normal, p);
      plane_least = i == 0 ? along : _mm256_min_ps(plane_least, along);
      plane_most = i == 0 ? along : _mm256_max_ps(plane_most, along);
    }
    __m256 parted = _mm256_cmp_ps(_mm256_add_ps(plane_most, apart), _mm256_load_ps(block.plane_from), _CMP_LT_OQ);
    parted = _mm256_or_ps(parted, _mm256_cmp_ps(_mm256_sub_ps(plane_least, apart), _mm256_load_ps(block.plane_to), _CMP_GT_OQ));
    for (int k = 0; k < 3; ++k) {
      const __m256 beyond = _mm256_cmp_ps(_mm256_add_ps(side_most[k], apart), _mm256_load_ps(block.side_from[k]), _CMP_LT_OQ);
      parted = _mm256_or_ps(parted, beyond);
    }
    if ((near[n] & ~static_cast<unsigned>(_mm256_movemask_ps(parted))) != 0) return false;
  }
  return true;
}

std::uint32_t Neighbourhood::place_of(std::uint32_t triangle, std::uint32_t perhaps) const noexcept {
  if (perhaps < static_cast<std::uint32_t>(count_) && triangle_at(perhaps) == triangle) return perhaps;
  const __m256i wanted = all_equal_to(triangle);
  const int blocks = (count_ + 7) / 8;
  for (int b = 0; b < blocks; ++b) {
    const unsigned mask = lanes(_mm256_cmpeq_epi32(load(blocks_[b].triangle), wanted));
    if (mask != 0) return static_cast<std::uint32_t>(8 * b + std::countr_zero(mask));
  }
  return kNowhere;
}

// Of a block's lanes, the triangles of the same object: vertices are numbered in each.
unsigned Neighbourhood::of_object(const Block& block, std::uint32_t triangle) const noexcept {
  const __m256i differs =
      _mm256_and_si256(_mm256_xor_si256(load(block.triangle), all_equal_to(triangle)), all_equal_to(geometry_->object_bits()));
  return lanes(_mm256_cmpeq_epi32(differs, _mm256_setzero_si256()));
}

Neighbourhood::Across Neighbourhood::across(std::uint32_t place, int k) const noexcept {
  const Block& own = blocks_[place / 8];
  const std::uint32_t from = own.vertex[k][place % 8];
  const std::uint32_t to = own.vertex[(k + 1) % 3][place % 8];
  const __m256i from_8 = all_equal_to(from);
  const __m256i to_8 = all_equal_to(to);
  const std::uint32_t triangle = triangle_at(place);
  // Gathered block by block, eight at a time, and looked at afterwards: in which of them it is, no processor can guess.
  Across found;
  const int blocks = (count_ + 7) / 8;
  for (int first = 0; first < blocks; first += 8) {
    std::uint64_t others = 0;
    for (int b = first; b < std::min(first + 8, blocks); ++b) {
      __m256i has_from = _mm256_setzero_si256();
      __m256i has_to = _mm256_setzero_si256();
      for (const auto& vertices : blocks_[b].vertex) {
        has_from = _mm256_or_si256(has_from, _mm256_cmpeq_epi32(load(vertices), from_8));
        has_to = _mm256_or_si256(has_to, _mm256_cmpeq_epi32(load(vertices), to_8));
      }
      const unsigned mask = lanes(_mm256_and_si256(has_from, has_to)) & of_object(blocks_[b], triangle);
      others |= static_cast<std::uint64_t>(mask) << (8 * (b - first));
    }
    const std::uint32_t base = static_cast<std::uint32_t>(8 * first);
    if (place - base < 64) others &= ~(std::uint64_t{1} << (place - base));
    if (others == 0) continue;
    if (found.place != kNowhere || (others & (others - 1)) != 0) return {};
    found.place = base + static_cast<std::uint32_t>(std::countr_zero(others));
  }
  if (found.place == kNowhere) return found;
  const Block& other = blocks_[found.place / 8];
  const std::uint32_t lane = found.place % 8;
  for (std::int16_t edge = 0; edge < 3; ++edge) {
    const std::uint32_t first = other.vertex[edge][lane];
    const std::uint32_t second = other.vertex[(edge + 1) % 3][lane];
    if (first == to && second == from) return {found.place, edge, true};
    if (first == from && second == to) return {found.place, edge, false};
  }
  return {};
}

int Neighbourhood::count_round(std::uint32_t place, int k) const noexcept {
  const __m256i vertex = all_equal_to(blocks_[place / 8].vertex[k][place % 8]);
  int found = 0;
  const int blocks = (count_ + 7) / 8;
  for (int b = 0; b < blocks; ++b) {
    __m256i has_it = _mm256_setzero_si256();
    for (const auto& vertices : blocks_[b].vertex) has_it = _mm256_or_si256(has_it, _mm256_cmpeq_epi32(load(vertices), vertex));
    found += std::popcount(lanes(has_it) & of_object(blocks_[b], triangle_at(place)));
  }
  return found;
}

bool Neighbourhood::fill(const TouchGeometry& geometry, const Box& region) noexcept {
  clear();
  if (!look_for(geometry, region)) return false;
  fetch();
  take();
  return true;
}

bool Neighbourhood::look_for(const TouchGeometry& geometry, const Box& region) noexcept {
  geometry_ = &geometry;
  wanted_ = region;
  found_count_ = 0;
  bool fits = true;
  geometry.for_each_overlapping(region, [&](std::uint32_t triangle) {
    if (found_count_ < kCapacity) {
      geometry.prefetch_indices(triangle);
      found_[found_count_++] = triangle;
    } else {
      fits = false;
    }
    return fits;
  });
  if (!fits) wanted_ = Box();
  return fits;
}

void Neighbourhood::fetch() const noexcept {
  for (int i = 0; i < found_count_; ++i) geometry_->prefetch_corners(found_[i]);
}

void Neighbourhood::take() noexcept {
  center_ = wanted_.center();
  is_prepared_.reset();
  for (int first = 0; first < found_count_; first += 8) {
    Block& block = blocks_[first / 8];
    copy(std::span(found_).subspan(first, std::min(8, found_count_ - first)), block);
    derive(block);
  }
  count_ = found_count_;
  region_ = wanted_;
  wanted_ = Box();
}

void Neighbourhood::copy(std::span<const std::uint32_t> triangles, Block& block) const noexcept {
  const __m256i three = _mm256_set_epi64x(0, -1, -1, -1);
  const __m256d center = _mm256_maskload_pd(center_.data(), three);
  // A point infinitely far away overlaps nothing.
  const __m128 nowhere = _mm_set1_ps(std::numeric_limits<float>::infinity());
  __m128 a[8];
  __m128 ab[8];
  __m128 ac[8];
  for (std::size_t lane = 0; lane < 8; ++lane) {
    if (lane >= triangles.size()) {
      a[lane] = nowhere;
      ab[lane] = _mm_setzero_ps();
      ac[lane] = _mm_setzero_ps();
      block.triangle[lane] = kNowhere;
      for (auto& vertices : block.vertex) vertices[lane] = kNowhere;
      continue;
    }
    const std::uint32_t triangle = triangles[lane];
    const ObjectGeometry::Corners corners = geometry_->corners(triangle);
    const __m256d corner = _mm256_maskload_pd(corners.a.data(), three);
    a[lane] = _mm256_cvtpd_ps(_mm256_sub_pd(corner, center));
    ab[lane] = _mm256_cvtpd_ps(_mm256_sub_pd(_mm256_maskload_pd(corners.b.data(), three), corner));
    ac[lane] = _mm256_cvtpd_ps(_mm256_sub_pd(_mm256_maskload_pd(corners.c.data(), three), corner));
    block.triangle[lane] = triangle;
    for (int k = 0; k < 3; ++k) block.vertex[k][lane] = corners.vertices[k];
  }
  turn(a, block.a);
  turn(ab, block.ab);
  turn(ac, block.ac);
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
  for (int k = 0; k < 3; ++k) {
    normal[k] = _mm256_mul_ps(normal[k], scale);
    _mm256_store_ps(block.unit_normal[k], normal[k]);
  }
  // Whatever a direction's rounding, what the corners have along it is what counts.
  const auto corner_least = [&](const __m256 direction[3]) {
    return _mm256_add_ps(dot(direction, a), _mm256_min_ps(zero, _mm256_min_ps(dot(direction, ab), dot(direction, ac))));
  };
  _mm256_store_ps(block.plane_from, _mm256_sub_ps(corner_least(normal), rounding));
  const __m256 highest = _mm256_max_ps(zero, _mm256_max_ps(dot(normal, ab), dot(normal, ac)));
  _mm256_store_ps(block.plane_to, _mm256_add_ps(_mm256_add_ps(dot(normal, a), highest), rounding));
  const __m256* const edges[3] = {ab, bc, ac};
  for (int k = 0; k < 3; ++k) {
    __m256 side[3];
    cross(normal, edges[k], side);
    const __m256 side_squared = dot(side, side);
    const __m256 has_length = _mm256_cmp_ps(side_squared, _mm256_set1_ps(1e-37F), _CMP_GT_OQ);
    __m256 unit = _mm256_and_ps(_mm256_div_ps(_mm256_set1_ps(1.0F), _mm256_sqrt_ps(side_squared)), has_length);
    if (k == 2) unit = _mm256_xor_ps(unit, no_sign);  // ac runs the other way round
    for (int i = 0; i < 3; ++i) {
      side[i] = _mm256_mul_ps(side[i], unit);
      _mm256_store_ps(block.side[k][i], side[i]);
    }
    _mm256_store_ps(block.side_from[k], _mm256_sub_ps(corner_least(side), rounding));
  }
}

}  // namespace hapton
