#include "core/collision/triangle_cache.h"

#include <bit>
#include <utility>

namespace hapton {
namespace {

// From this squared length on, terms underflow by at most 2^-150, less than a float's rounding, and the inverse is a float.
constexpr float kLeastSquare = 0x1p-122F;

Float8 dot(const Float8 u[3], const Float8 v[3]) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }

Float8 dot(const float u[3][8], const Float8 v[3]) {
  const Float8 xy = Float8::load(u[0]) * v[0] + Float8::load(u[1]) * v[1];
  return xy + Float8::load(u[2]) * v[2];
}

void load(const float from[3][8], Float8 into[3]) {
  for (int k = 0; k < 3; ++k) into[k] = Float8::load(from[k]);
}

// off = from - clamp(from . edge / |edge|^2) edge: from the edge's closest point to the query; returns its squared length.
Float8 off_edge(const Float8 from[3], const Float8 edge[3], const Float8& inverse, Float8 off[3]) {
  Float8 t = dot(from, edge) * inverse;
  t = min(max(t, Float8(0.0F)), Float8(1.0F));
  for (int k = 0; k < 3; ++k) off[k] = from[k] - t * edge[k];
  return dot(off, off);
}

void cross(const Float8 u[3], const Float8 v[3], Float8 into[3]) {
  into[0] = u[1] * v[2] - u[2] * v[1];
  into[1] = u[2] * v[0] - u[0] * v[2];
  into[2] = u[0] * v[1] - u[1] * v[0];
}

void choose(const Float8& mask, const Float8 other[3], Float8 into[3]) {
  for (int k = 0; k < 3; ++k) into[k] = select(mask, other[k], into[k]);
}

// Transposes eight points into eight of each coordinate.
void turn(const Float4 points[8], float into[3][8]) {
  for (int half = 0; half < 8; half += 4) {
    Float4 x = points[half];
    Float4 y = points[half + 1];
    Float4 z = points[half + 2];
    Float4 w = points[half + 3];
    transpose(x, y, z, w);
    store(&into[0][half], x);
    store(&into[1][half], y);
    store(&into[2][half], z);
  }
}

Uint32x8 load(const std::uint32_t from[8]) { return Uint32x8::load(from); }

Uint32x8 all_equal_to(std::uint32_t value) { return Uint32x8(value); }

}  // namespace

TriangleCache::Bound TriangleCache::separation_bound(const Block& block, const Float8 p[3], const Float8 motion[3]) noexcept {
  Float8 a[3];
  Float8 ab[3];
  Float8 ac[3];
  Float8 ap[3];
  Float8 bp[3];
  Float8 bc[3];
  load(block.a, a);
  load(block.ab, ab);
  load(block.ac, ac);
  for (int k = 0; k < 3; ++k) {
    ap[k] = p[k] - a[k];
    bp[k] = ap[k] - ab[k];
    bc[k] = ac[k] - ab[k];
  }
  Float8 off[3];
  Float8 other[3];
  Float8 best = off_edge(ap, ab, Float8::load(block.inverse_ab), off);
  Float8 squared = off_edge(ap, ac, Float8::load(block.inverse_ac), other);
  Float8 nearer = squared < best;
  choose(nearer, other, off);
  best = min(best, squared);
  squared = off_edge(bp, bc, Float8::load(block.inverse_bc), other);
  nearer = squared < best;
  choose(nearer, other, off);
  best = min(best, squared);

  // Inside the triangle's prism the face is closest. The three side tests need only be approximate.
  Float8 normal[3];
  load(block.unit_normal, normal);
  Float8 cross_ap[3];  // ap x normal: its dot with an edge tells the side
  cross(ap, normal, cross_ap);
  Float8 cross_bp[3];
  cross(bp, normal, cross_bp);
  const Float8 zero = Float8(0.0F);
  Float8 inside = dot(cross_ap, ab) > zero;
  inside = inside & (dot(cross_bp, bc) > zero);
  inside = inside & (dot(cross_ap, ac) < zero);
  const Float8 height = dot(ap, normal);
  const Float8 sign = height & Float8(-0.0F);
  for (int k = 0; k < 3; ++k) other[k] = normal[k] ^ sign;
  // Unit direction u off the edges, or the normal inside.
  const Float8 length = sqrt(best);
  const Float8 inverse = (Float8(1.0F) / length) & (best > zero);
  for (int k = 0; k < 3; ++k) off[k] = off[k] * inverse;
  choose(inside, other, off);

  // u . (q - x) for every x of the triangle is at least its value at the corner farthest along u.
  const Float8 support = max(zero, max(dot(off, ab), dot(off, ac)));
  const Float8 distance = dot(off, ap) - support - Float8::load(block.rounding);
  return {distance, min(zero, dot(off, motion))};
}

// The lanes of a block whose boxes overlap.
unsigned TriangleCache::overlapping(const Block& block, const Float8 low[3], const Float8 high[3]) noexcept {
  Float8 hit = Float8::load(block.low[0]) <= high[0];
  hit = hit & (Float8::load(block.high[0]) >= low[0]);
  for (int k = 1; k < 3; ++k) {
    hit = hit & (Float8::load(block.low[k]) <= high[k]);
    hit = hit & (Float8::load(block.high[k]) >= low[k]);
  }
  return sign_bits(hit);
}

int TriangleCache::find_candidates(const Vec3& p, const Vec3& motion, double radius, const Box& path,
                                   std::array<Candidate, kCapacity>& candidates) const noexcept {
  Float8 low[3];
  Float8 high[3];
  Float8 start[3];
  Float8 move[3];
  float magnitude = 0.0F;
  for (int k = 0; k < 3; ++k) {
    low[k] = Float8(detail::round_down(path.low[k] - centre_[k]));
    high[k] = Float8(detail::round_up(path.high[k] - centre_[k]));
    const auto s = static_cast<float>(p[k] - centre_[k]);
    const auto m = static_cast<float>(motion[k]);
    start[k] = Float8(s);
    move[k] = Float8(m);
    magnitude += std::fabs(s) + std::fabs(m);
  }
  // Rounding of the query's part of the bound: a dozen operations on values below `magnitude`.
  const Float8 enough = Float8(detail::round_up(radius) + magnitude * 0x1p-20F);
  const Float8 zero = Float8(0.0F);
  int n = 0;
  const int blocks = (count_ + 7) / 8;
  for (int b = 0; b < blocks; ++b) {
    const Block& block = blocks_[b];
    const unsigned near = overlapping(block, low, high);
    if (near == 0) continue;
    const Bound bound = separation_bound(block, start, move);
    const Float8 gap = bound.distance - enough;
    const Float8 misses = gap + bound.approach > zero;
    unsigned mask = near & ~sign_bits(misses);
    if (mask == 0) continue;
    // gap / -approach, rounded down by a few units; zero if the gap is already closed.
    const Float8 time = gap / (zero - bound.approach) * Float8(1.0F - 0x1p-21F);
    alignas(32) float earliest[8];
    store(earliest, time & (gap > zero));
    for (; mask != 0; mask &= mask - 1) {
      const int lane = std::countr_zero(mask);
      candidates[n] = {earliest[lane], block.triangle[lane], static_cast<std::uint32_t>(8 * b + lane)};
      if (candidates[n].earliest < candidates[0].earliest) std::swap(candidates[n], candidates[0]);
      ++n;
    }
  }
  return n;
}

bool TriangleCache::is_clear(std::span<const Vec3> path, double radius, std::span<const std::uint32_t> except) const noexcept {
  constexpr std::size_t kMostPoints = 32;
  if (path.size() > kMostPoints) return false;
  std::array<std::uint8_t, kCapacity / 8> excepted = {};
  for (const std::uint32_t slot : except) excepted[slot / 8] |= static_cast<std::uint8_t>(1U << (slot % 8));
  std::array<std::array<float, 3>, kMostPoints> points;
  std::array<float, 3> least = {};
  std::array<float, 3> most = {};
  float magnitude = 0.0F;
  for (std::size_t i = 0; i < path.size(); ++i) {
    float size = 0.0F;
    for (int k = 0; k < 3; ++k) {
      const auto x = static_cast<float>(path[i][k] - centre_[k]);
      points[i][k] = x;
      least[k] = i == 0 ? x : std::min(least[k], x);
      most[k] = i == 0 ? x : std::max(most[k], x);
      size += std::fabs(x);
    }
    magnitude = std::max(magnitude, size);
  }
  const float enough = detail::round_up(radius) + magnitude * 0x1p-20F;
  Float8 low[3];
  Float8 high[3];
  for (int k = 0; k < 3; ++k) {
    low[k] = Float8(least[k] - enough);
    high[k] = Float8(most[k] + enough);
  }
  const Float8 apart = Float8(enough);
  // In two passes, first selecting blocks and then testing them: a branch for each block would often be mispredicted.
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
    Float8 side_most[3];  // over the polyline
    Float8 plane_least;
    Float8 plane_most;
    for (std::size_t i = 0; i < path.size(); ++i) {
      const Float8 p[3] = {Float8(points[i][0]), Float8(points[i][1]), Float8(points[i][2])};
      for (int k = 0; k < 3; ++k) {
        const Float8 along = dot(block.side[k], p);
        side_most[k] = i == 0 ? along : max(side_most[k], along);
      }
      const Float8 along = dot(block.unit_normal, p);
      plane_least = i == 0 ? along : min(plane_least, along);
      plane_most = i == 0 ? along : max(plane_most, along);
    }
    Float8 parted = plane_most + apart < Float8::load(block.plane_from);
    parted = parted | (plane_least - apart > Float8::load(block.plane_to));
    for (int k = 0; k < 3; ++k) {
      const Float8 beyond = side_most[k] + apart < Float8::load(block.side_from[k]);
      parted = parted | beyond;
    }
    if ((near[n] & ~sign_bits(parted)) != 0) return false;
  }
  return true;
}

std::uint32_t TriangleCache::slot_of(std::uint32_t triangle, std::uint32_t hint) const noexcept {
  if (hint < static_cast<std::uint32_t>(count_) && triangle_at(hint) == triangle) return hint;
  const Uint32x8 wanted = all_equal_to(triangle);
  const int blocks = (count_ + 7) / 8;
  for (int b = 0; b < blocks; ++b) {
    const unsigned mask = sign_bits(load(blocks_[b].triangle) == wanted);
    if (mask != 0) return static_cast<std::uint32_t>(8 * b + std::countr_zero(mask));
  }
  return kNoSlot;
}

// The lanes of a block whose triangles are of the same object: vertices are numbered per object.
unsigned TriangleCache::of_object(const Block& block, std::uint32_t triangle) const noexcept {
  const Uint32x8 differs = (load(block.triangle) ^ all_equal_to(triangle)) & all_equal_to(geometry_->object_bits());
  return sign_bits(differs == Uint32x8(0U));
}

TriangleCache::Adjacent TriangleCache::adjacent(std::uint32_t slot, int k) const noexcept {
  const Block& own = blocks_[slot / 8];
  const std::uint32_t from = own.vertex[k][slot % 8];
  const std::uint32_t to = own.vertex[(k + 1) % 3][slot % 8];
  const Uint32x8 from_8 = all_equal_to(from);
  const Uint32x8 to_8 = all_equal_to(to);
  const std::uint32_t triangle = triangle_at(slot);
  // Masks of eight blocks are collected before they are examined: a branch for each block would often be mispredicted.
  Adjacent found;
  const int blocks = (count_ + 7) / 8;
  for (int first = 0; first < blocks; first += 8) {
    std::uint64_t others = 0;
    for (int b = first; b < std::min(first + 8, blocks); ++b) {
      Uint32x8 has_from = Uint32x8(0U);
      Uint32x8 has_to = Uint32x8(0U);
      for (const auto& vertices : blocks_[b].vertex) {
        has_from = has_from | (load(vertices) == from_8);
        has_to = has_to | (load(vertices) == to_8);
      }
      const unsigned mask = sign_bits(has_from & has_to) & of_object(blocks_[b], triangle);
      others |= static_cast<std::uint64_t>(mask) << (8 * (b - first));
    }
    const std::uint32_t base = static_cast<std::uint32_t>(8 * first);
    if (slot - base < 64) others &= ~(std::uint64_t{1} << (slot - base));
    if (others == 0) continue;
    if (found.slot != kNoSlot || (others & (others - 1)) != 0) return {};
    found.slot = base + static_cast<std::uint32_t>(std::countr_zero(others));
  }
  if (found.slot == kNoSlot) return found;
  const Block& other = blocks_[found.slot / 8];
  const std::uint32_t lane = found.slot % 8;
  for (std::int16_t edge = 0; edge < 3; ++edge) {
    const std::uint32_t first = other.vertex[edge][lane];
    const std::uint32_t second = other.vertex[(edge + 1) % 3][lane];
    if (first == to && second == from) return {found.slot, edge, true};
    if (first == from && second == to) return {found.slot, edge, false};
  }
  return {};
}

int TriangleCache::count_at_vertex(std::uint32_t slot, int k) const noexcept {
  const Uint32x8 vertex = all_equal_to(blocks_[slot / 8].vertex[k][slot % 8]);
  int found = 0;
  const int blocks = (count_ + 7) / 8;
  for (int b = 0; b < blocks; ++b) {
    Uint32x8 has_it = Uint32x8(0U);
    for (const auto& vertices : blocks_[b].vertex) has_it = has_it | (load(vertices) == vertex);
    found += std::popcount(sign_bits(has_it) & of_object(blocks_[b], triangle_at(slot)));
  }
  return found;
}

bool TriangleCache::rebuild(const TouchGeometry& geometry, const Box& region) noexcept {
  clear();
  if (!query(geometry, region)) return false;
  fetch();
  commit();
  return true;
}

bool TriangleCache::query(const TouchGeometry& geometry, const Box& region) noexcept {
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

void TriangleCache::fetch() const noexcept {
  for (int i = 0; i < found_count_; ++i) geometry_->prefetch_corners(found_[i]);
}

void TriangleCache::commit() noexcept {
  centre_ = wanted_.centre();
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

void TriangleCache::copy(std::span<const std::uint32_t> triangles, Block& block) const noexcept {
  const Double4 centre = Double4::load_three(centre_.data());
  // A point at infinity overlaps nothing.
  const Float4 nowhere = Float4(std::numeric_limits<float>::infinity());
  Float4 a[8];
  Float4 ab[8];
  Float4 ac[8];
  for (std::size_t lane = 0; lane < 8; ++lane) {
    if (lane >= triangles.size()) {
      a[lane] = nowhere;
      ab[lane] = Float4(0.0F);
      ac[lane] = Float4(0.0F);
      block.triangle[lane] = kNoSlot;
      for (auto& vertices : block.vertex) vertices[lane] = kNoSlot;
      continue;
    }
    const std::uint32_t triangle = triangles[lane];
    const ObjectGeometry::Corners corners = geometry_->corners(triangle);
    const Double4 corner = Double4::load_three(corners.a.data());
    a[lane] = rounded(corner - centre);
    ab[lane] = rounded(Double4::load_three(corners.b.data()) - corner);
    ac[lane] = rounded(Double4::load_three(corners.c.data()) - corner);
    block.triangle[lane] = triangle;
    for (int k = 0; k < 3; ++k) block.vertex[k][lane] = corners.vertices[k];
  }
  turn(a, block.a);
  turn(ab, block.ab);
  turn(ac, block.ac);
}

void TriangleCache::derive(Block& block) noexcept {
  Float8 a[3];
  Float8 ab[3];
  Float8 ac[3];
  Float8 bc[3];
  load(block.a, a);
  load(block.ab, ab);
  load(block.ac, ac);
  const Float8 zero = Float8(0.0F);
  const Float8 no_sign = Float8(-0.0F);
  const auto magnitude = [&](const Float8& x) { return and_not(no_sign, x); };
  Float8 size = zero;
  for (int k = 0; k < 3; ++k) {
    bc[k] = ac[k] - ab[k];
    size = size + (magnitude(a[k]) + (magnitude(ab[k]) + magnitude(ac[k])));
  }
  const Float8 rounding = size * Float8(0x1p-19F);
  store(block.rounding, rounding);
  for (int k = 0; k < 3; ++k) {
    const Float8 least = min(zero, min(ab[k], ac[k]));
    const Float8 most = max(zero, max(ab[k], ac[k]));
    store(block.low[k], a[k] + least - rounding);
    store(block.high[k], a[k] + most + rounding);
  }
  // A zero edge gets factor zero; so does one that overflows, which only weakens the bound.
  const auto inverse = [&](const Float8 edge[3]) {
    const Float8 squared = dot(edge, edge);
    return (Float8(1.0F) / squared) & (squared > Float8(kLeastSquare));
  };
  store(block.inverse_ab, inverse(ab));
  store(block.inverse_ac, inverse(ac));
  store(block.inverse_bc, inverse(bc));
  Float8 normal[3];
  cross(ab, ac, normal);
  const Float8 squared = dot(normal, normal);
  const Float8 has_area = squared > Float8(kLeastSquare);
  const Float8 scale = (Float8(1.0F) / sqrt(squared)) & has_area;
  for (int k = 0; k < 3; ++k) {
    normal[k] = normal[k] * scale;
    store(block.unit_normal[k], normal[k]);
  }
  // Computed from the corners as they are, so the rounding of a direction does not matter.
  const auto corner_least = [&](const Float8 direction[3]) {
    return dot(direction, a) + min(zero, min(dot(direction, ab), dot(direction, ac)));
  };
  store(block.plane_from, corner_least(normal) - rounding);
  const Float8 highest = max(zero, max(dot(normal, ab), dot(normal, ac)));
  store(block.plane_to, dot(normal, a) + highest + rounding);
  const Float8* const edges[3] = {ab, bc, ac};
  for (int k = 0; k < 3; ++k) {
    Float8 side[3];
    cross(normal, edges[k], side);
    const Float8 side_squared = dot(side, side);
    const Float8 has_length = side_squared > Float8(kLeastSquare);
    Float8 unit = (Float8(1.0F) / sqrt(side_squared)) & has_length;
    if (k == 2) unit = unit ^ no_sign;  // ac is reversed
    for (int i = 0; i < 3; ++i) {
      side[i] = side[i] * unit;
      store(block.side[k][i], side[i]);
    }
    store(block.side_from[k], corner_least(side) - rounding);
  }
}

}  // namespace hapton
