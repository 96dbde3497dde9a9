#include "core/collision/surface_adjacency.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/collision/beyond_plane.h"
#include "core/collision/near_sectors.h"
#include "core/collision/triangle_pair.h"
#include "core/geometry/point_triangle.h"
#include "core/math/exact_cross.h"
#include "core/math/float8.h"

namespace hapton {
namespace {

using Corners = std::array<Vec3, 3>;

Corners corners_of(std::span<const Vec3> vertices, const Triangle& t) { return {vertices[t[0]], vertices[t[1]], vertices[t[2]]}; }

bool repeats_vertex(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// Whether the height of a triangle over its longest edge is at least kMinHeight. A plain cross product suffices from four times that on.
bool is_high(const Corners& c) {
  const Vec3 ab = c[1] - c[0];
  const Vec3 ac = c[2] - c[0];
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (c[2] - c[1]).squaredNorm()});
  constexpr double kMin = SurfaceAdjacency::kMinHeight;
  if (ab.cross(ac).squaredNorm() > 16.0 * kMin * kMin * longest) return true;
  return longest > 0.0 && accurate_cross(ab, ac).squaredNorm() >= kMin * kMin * longest;
}

// Whether all points of b are on one side of the plane through `at`, farther than `margin` away. The normal need not have unit length.
bool is_beyond(const Vec3& normal, const Vec3& at, const Corners& b, double margin) {
  const double least = margin * normal.norm();
  const double h0 = normal.dot(b[0] - at);
  const double h1 = normal.dot(b[1] - at);
  const double h2 = normal.dot(b[2] - at);
  return (h0 > least && h1 > least && h2 > least) || (h0 < -least && h1 < -least && h2 < -least);
}

// Whether a plane separates triangle b from a by more than `margin`: the plane of a, or one through an edge of a at a right angle to a.
bool has_separating_plane(const Corners& a, const Corners& b, double margin) {
  const Vec3 normal = accurate_cross(a[1] - a[0], a[2] - a[0]);
  if (is_beyond(normal, a[0], b, margin)) return true;
  for (int k = 0; k < 3; ++k) {
    const Vec3 outward = (a[(k + 1) % 3] - a[k]).cross(normal);
    const double least = margin * outward.norm();
    if (outward.dot(b[0] - a[k]) > least && outward.dot(b[1] - a[k]) > least && outward.dot(b[2] - a[k]) > least) return true;
  }
  return false;
}

double segment_distance(const Vec3& p, const Vec3& u, const Vec3& q, const Vec3& v) {
  const Vec3 r = p - q;
  const double uu = u.squaredNorm();
  const double vv = v.squaredNorm();
  const double uv = u.dot(v);
  const double ur = u.dot(r);
  const double vr = v.dot(r);
  const double det = uu * vv - uv * uv;
  double s = det > 0.0 ? std::clamp((uv * vr - ur * vv) / det, 0.0, 1.0) : 0.0;
  const double t = vv > 0.0 ? std::clamp((uv * s + vr) / vv, 0.0, 1.0) : 0.0;
  s = uu > 0.0 ? std::clamp((uv * t - ur) / uu, 0.0, 1.0) : 0.0;
  return (r + s * u - t * v).norm();
}

// The sector between two edges from an apex at the origin.
struct Sector {
  std::array<Vec3, 2> edge;
  Vec3 normal;
  std::array<Vec3, 2> inward;  // in the plane, perpendicular to the edges

  Sector(const Vec3& first, const Vec3& last)
      : edge{first, last}, normal(accurate_cross(first, last)), inward{normal.cross(first), last.cross(normal)} {}
  bool is_over(const Vec3& v) const { return inward[0].dot(v) > 0.0 && inward[1].dot(v) > 0.0; }
};

// Whether the angle between a direction and a sector is more than kMinAngle.
bool is_far_from(const Sector& sector, const Vec3& v) {
  constexpr double kAngle = SurfaceAdjacency::kMinAngle;
  const double length = v.norm();
  if (sector.is_over(v)) return std::fabs(sector.normal.dot(v)) > kAngle * length * sector.normal.norm();
  return std::all_of(sector.edge.begin(), sector.edge.end(),
                     [&](const Vec3& edge) { return edge.dot(v) < 0.0 || edge.cross(v).norm() > kAngle * length * edge.norm(); });
}

// Whether two sectors with a common apex are more than kMinAngle apart as seen from it: no edge of one is near the other, and they do not
// intersect.
bool are_sectors_apart(const std::array<Vec3, 2>& edges_a, const std::array<Vec3, 2>& edges_b) {
  const Sector a(edges_a[0], edges_a[1]);
  const Sector b(edges_b[0], edges_b[1]);
  for (int k = 0; k < 2; ++k) {
    if (!is_far_from(a, b.edge[k]) || !is_far_from(b, a.edge[k])) return false;
  }
  const Vec3 line = a.normal.cross(b.normal);
  return !(a.is_over(line) && b.is_over(line)) && !(a.is_over(-line) && b.is_over(-line));
}

// Whether the angle between two triangles at their common edge is at most kMinAngle.
bool is_folded_flat(const Vec3& edge, const Vec3& to_a, const Vec3& to_b) {
  const Vec3 a = edge.cross(to_a);
  const Vec3 b = edge.cross(to_b);
  return a.dot(b) > 0.0 && a.cross(b).norm() <= SurfaceAdjacency::kMinAngle * a.norm() * b.norm();
}

}  // namespace

bool are_apart(const Corners& a, const Corners& b, double margin) noexcept {
  if (has_separating_plane(a, b, margin) || has_separating_plane(b, a, margin)) return true;
  if (intersect_triangles({a, b}).meets) return false;
  for (int i = 0; i < 3; ++i) {
    if (separation_from_triangle(a[i], b[0], b[1], b[2]).distance <= margin) return false;
    if (separation_from_triangle(b[i], a[0], a[1], a[2]).distance <= margin) return false;
    for (int j = 0; j < 3; ++j) {
      if (segment_distance(a[i], a[(i + 1) % 3] - a[i], b[j], b[(j + 1) % 3] - b[j]) <= margin) return false;
    }
  }
  return true;
}

bool is_pair_walkable(std::span<const Vec3> vertices, const Triangle& s, const Triangle& t, double margin) noexcept {
  int shared = 0;
  std::array<int, 3> in_s = {};
  std::array<int, 3> in_t = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3 && shared < 3; ++j) {
      if (s[i] != t[j]) continue;
      in_s[shared] = i;
      in_t[shared] = j;
      ++shared;
    }
  }
  if (shared > 0 && (repeats_vertex(s) || repeats_vertex(t))) return false;  // such a triangle forms no sector at its vertices
  if (shared == 3) return false;
  if (shared == 0) return are_apart(corners_of(vertices, s), corners_of(vertices, t), margin);
  const Vec3& apex = vertices[s[in_s[0]]];
  if (shared == 2) {
    const Vec3 edge = vertices[s[in_s[1]]] - apex;
    return !is_folded_flat(edge, vertices[s[3 - in_s[0] - in_s[1]]] - apex, vertices[t[3 - in_t[0] - in_t[1]]] - apex);
  }
  const auto edges = [&](const Triangle& of, int k) -> std::array<Vec3, 2> {
    return {vertices[of[(k + 1) % 3]] - apex, vertices[of[(k + 2) % 3]] - apex};
  };
  return are_sectors_apart(edges(s, in_s[0]), edges(t, in_t[0]));
}

namespace {

// Pairs each half edge that shares its upper vertex with at most one other of the list: with that one, or else with itself.
template <class Pair>
void pair_sorted(std::span<const std::uint32_t> high, std::span<const std::uint32_t> codes, std::size_t count, Pair&& pair) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) { return high[a] < high[b]; });
  for (std::size_t i = 0, end = 0; i < count; i = end) {
    while (end < count && high[order[end]] == high[order[i]]) ++end;
    if (end - i > 2) continue;
    pair(codes[order[i]], codes[order[end - 1]]);
    if (end - i == 2) pair(codes[order[end - 1]], codes[order[i]]);
  }
}

}  // namespace

SurfaceAdjacency::SurfaceAdjacency(std::size_t vertex_count, std::span<const Triangle> triangles) : sides_(triangles.size()) {
  pair_edges(vertex_count, triangles);
}

// There is a list of half edges for each lower vertex; within a list, those with the same upper vertex are found. The links of a list are
// stored in the slots for the half edges' neighbours until these are known.
void SurfaceAdjacency::pair_edges(std::size_t vertex_count, std::span<const Triangle> triangles) {
  const auto place = [&](std::uint32_t code) -> std::uint32_t& { return sides_[code >> 3].adjacent[code >> 1 & 3U]; };
  LargeVector<std::uint32_t> last(vertex_count, kNone);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corner = triangles[t];
    if (repeats_vertex(corner)) continue;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t from = corner[k];
      const std::uint32_t to = corner[k == 2 ? 0 : k + 1];
      const std::uint32_t code = t << 3 | k << 1 | (from < to ? 1U : 0U);
      place(code) = std::exchange(last[std::min(from, to)], code);
    }
  }
  // A half edge that is alone at its edge is its own partner.
  const auto pair = [&](std::uint32_t code, std::uint32_t other) {
    const bool flips = code == other || ((code ^ other) & 1U) == 0;
    place(code) = (other & ~1U) | (flips ? 1U : 0U);
  };
  std::vector<std::uint32_t> high;  // upper vertex of each half edge of a list, with room to read in eights
  std::vector<std::uint32_t> codes;
  for (std::size_t v = 0; v < vertex_count; ++v) {
    std::size_t count = 0;
    for (std::uint32_t code = last[v]; code != kNone; ++count) {
      if (count + 8 > high.size()) {
        high.resize(2 * count + 16);
        codes.resize(high.size());
      }
      const std::uint32_t k = code >> 1 & 3U;
      high[count] = triangles[code >> 3][(code & 1U) == 0 ? k : k == 2 ? 0 : k + 1];
      codes[count] = code;
      code = std::exchange(place(code), kNone);
    }
    if (count > kLargeFan) {
      pair_sorted(high, codes, count, pair);
      continue;
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Uint32x8 own = Uint32x8(high[i]);
      int others = -1;
      std::size_t other = i;
      for (std::size_t j = 0; j < count; j += 8) {
        const Uint32x8 same = Uint32x8::load_unaligned(&high[j]) == own;
        auto mask = sign_bits(same);
        mask &= count - j < 8 ? (1U << (count - j)) - 1U : 0xFFU;
        others += std::popcount(mask);
        if (i - j < 8) mask &= ~(1U << (i - j));
        other = mask != 0 ? j + static_cast<std::size_t>(std::countr_zero(mask)) : other;
      }
      if (others <= 1) pair(codes[i], codes[other]);
    }
  }
}

std::size_t SurfaceAdjacency::walkable_count() const {
  return static_cast<std::size_t>(std::count_if(sides_.begin(), sides_.end(), [](const Sides& sides) { return sides.is_walkable != 0; }));
}

// Goes round a vertex from side to side, each time across the edge that it did not enter by. An open fan is traversed on both sides.
bool SurfaceAdjacency::is_whole_fan(std::span<const Triangle> triangles, std::uint32_t start, int corner, std::uint32_t valence) const {
  const std::uint32_t vertex = triangles[start][corner];
  std::uint32_t t = start;
  bool is_back = false;
  bool is_open = false;
  int exit_edge = corner;
  for (std::uint32_t count = 1; count <= 2 * valence; ++count) {
    const Adjacent next = adjacent(t, exit_edge);
    if (!next.exists) return false;
    is_back ^= next.flips;
    is_open = is_open || next.triangle == t;
    t = next.triangle;
    exit_edge = triangles[t][next.edge] == vertex ? (next.edge + 2) % 3 : (next.edge + 1) % 3;
    if (t == start && !is_back && exit_edge == corner) return count == (is_open ? 2 * valence : valence);
  }
  return false;
}

// Finds even fans (Fan::even). The axis of a fan is the sum of the normals at its vertex. In an even fan each normal is within 60 degrees
// of the axis, each triangle spans more than kMinAngle about it, and the triangles together go round it once. So there is only one fan, and
// the sectors of its triangles do not overlap. Each triangle adds its part, in any order; full turns are counted where triangles cross a
// half-plane that contains the axis. Both triangles at an edge compute the same numbers for it. Marks other fans as `broken`.
SurfaceAdjacency::Fans SurfaceAdjacency::find_even_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const {
  struct FanSums {
    Eigen::Vector3f axis = Eigen::Vector3f::Zero();  // may be rounded: all triangles at the vertex use the same
    std::uint16_t valence = 0;
    std::uint16_t turns = 0;
    bool is_even = true;
  };
  static_assert(kMaxValence < 65535);
  LargeVector<FanSums> all_sums(vertices.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corner = triangles[t];
    const Vec3& a = vertices[corner[0]];
    const Vec3 normal = (vertices[corner[1]] - a).cross(vertices[corner[2]] - a);
    const bool repeats = repeats_vertex(corner);
    for (int k = 0; k < 3; ++k) {
      FanSums& sums = all_sums[corner[k]];
      const Adjacent next = adjacent(t, k);
      const bool runs_on = next.exists && !next.flips && !repeats;
      sums.axis += normal.cast<float>();
      sums.valence = static_cast<std::uint16_t>(std::min(sums.valence + 1, kMaxValence + 1));
      sums.is_even = sums.is_even && runs_on;
      if (!runs_on) all_sums[corner[(k + 1) % 3]].is_even = false;
    }
  }
  for (const Triangle& corner : triangles) {
    const std::array<Vec3, 3> edge = {vertices[corner[1]] - vertices[corner[0]], vertices[corner[2]] - vertices[corner[1]],
                                      vertices[corner[0]] - vertices[corner[2]]};
    const std::array<double, 3> squared = {edge[0].squaredNorm(), edge[1].squaredNorm(), edge[2].squaredNorm()};
    const Vec3 normal = edge[0].cross(edge[1]);
    const double least_lean = 0.25 * normal.squaredNorm();
    for (int k = 0; k < 3; ++k) {
      FanSums& sums = all_sums[corner[k]];
      const Vec3 axis = sums.axis.cast<double>();
      const int before = (k + 2) % 3;
      constexpr double kMin = 8.0 * kMinAngle;
      const double along = axis.dot(normal);
      const double least = std::max(least_lean, kMin * kMin * squared[k] * squared[before]);
      sums.is_even = sums.is_even && along > 0.0 && along * along > least * axis.squaredNorm();
      // side: the component along axis x X or axis x Y, with X or Y, whichever is farther from the axis: all triangles choose alike.
      const bool leans_from_x = std::fabs(axis.x()) <= std::fabs(axis.y());
      const auto side = [&](const Vec3& e) {
        return leans_from_x ? axis.z() * e.y() - axis.y() * e.z() : axis.x() * e.z() - axis.z() * e.x();
      };
      // Both triangles at an edge use its direction from the vertex outwards.
      if (side(edge[k]) < 0.0 && side(-edge[before]) >= 0.0) ++sums.turns;
    }
  }
  Fans fans{std::vector<Fan>(vertices.size(), Fan::broken), {}};
  for (std::uint32_t v = 0; v < vertices.size(); ++v) {
    const FanSums& sums = all_sums[v];
    if (sums.is_even && sums.turns == 1 && sums.valence <= kMaxValence) fans.of_vertex[v] = Fan::even;
    if (sums.valence > kLargeFan) fans.large.push_back(v);
  }
  return fans;
}

SurfaceAdjacency::Fans SurfaceAdjacency::find_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles) const {
  Fans found = find_even_fans(vertices, triangles);
  std::vector<Fan>& fans = found.of_vertex;
  if (std::find(fans.begin(), fans.end(), Fan::broken) == fans.end()) return found;
  std::vector<std::uint32_t> valence(vertices.size(), 0);
  for (const Triangle& t : triangles) {
    if (repeats_vertex(t)) continue;
    for (const std::uint32_t v : t) valence[v] += fans[v] == Fan::even ? 0 : 1;
  }
  for (std::uint32_t start = 0; start < triangles.size(); ++start) {
    if (repeats_vertex(triangles[start])) continue;
    for (int c = 0; c < 3; ++c) {
      std::uint32_t& count = valence[triangles[start][c]];
      if (count > 0 && count <= kMaxValence && is_whole_fan(triangles, start, c, count)) fans[triangles[start][c]] = Fan::whole;
      count = 0;  // each vertex is visited once
    }
  }
  return found;
}

// Marks the triangles of large fans. In each large fan that is not even, compares the triangles with each other, so that they need no
// further test. Returns the number of tests.
std::size_t SurfaceAdjacency::compare_in_large_fans(std::span<const Vec3> vertices, std::span<const Triangle> triangles, double margin,
                                                    Fans& fans) {
  has_large_fans_ = !fans.large.empty();
  if (!has_large_fans_) return 0;
  std::vector<std::uint32_t> place(vertices.size(), kNone);
  for (std::uint32_t i = 0; i < fans.large.size(); ++i) place[fans.large[i]] = i;
  std::vector<std::vector<std::uint32_t>> around(fans.large.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (const std::uint32_t v : triangles[t]) {
      if (place[v] == kNone) continue;
      around[place[v]].push_back(t);
    }
  }
  for (const std::uint32_t v : fans.large) mark_large_fan(v, around[place[v]], triangles);
  std::size_t tests = 0;
  for (const std::uint32_t v : fans.large) {
    if (fans.of_vertex[v] == Fan::even) mark_convex_fan(around[place[v]], vertices, triangles);
    if (fans.of_vertex[v] == Fan::even) continue;
    tests += compare_at(v, around[place[v]], vertices, triangles, margin);
    fans.of_vertex[v] = Fan::compared;
  }
  return tests;
}

void SurfaceAdjacency::mark_large_fan(std::uint32_t vertex, std::span<const std::uint32_t> around, std::span<const Triangle> triangles) {
  for (const std::uint32_t t : around) {
    const Triangle& corner = triangles[t];
    const int k = corner[0] == vertex ? 0 : corner[1] == vertex ? 1 : 2;
    sides_[t].fan = static_cast<std::uint16_t>(sides_[t].fan != 0 ? sides_[t].fan | kSeveral : kLarge | k);
  }
}

// A closed fan that goes round once is convex if it is convex at each of its edges.
void SurfaceAdjacency::mark_convex_fan(std::span<const std::uint32_t> around, std::span<const Vec3> vertices,
                                       std::span<const Triangle> triangles) {
  constexpr double kRounding = 0x1p-49;  // rounding of a height: four times the grid of coordinates
  // In a triangle that is in several large fans, the stored corner may be that of another fan.
  if (std::any_of(around.begin(), around.end(), [&](std::uint32_t t) { return (sides_[t].fan & kSeveral) != 0; })) return;
  bool is_front = true;
  bool is_back = true;
  for (const std::uint32_t t : around) {
    const int k = sides_[t].fan & kFanCorner;
    const Adjacent next = adjacent(t, k);
    const auto [a, b, c] = corners_of(vertices, triangles[t]);
    const Vec3 normal = accurate_cross(b - a, c - a);
    const double height = normal.dot(vertices[triangles[next.triangle][(next.edge + 2) % 3]] - a);
    is_front = is_front && height <= kRounding * normal.norm();
    is_back = is_back && height >= -kRounding * normal.norm();
  }
  const int convex = (is_front ? kConvexFront : 0) | (is_back ? kConvexBack : 0);
  for (const std::uint32_t t : around) sides_[t].fan = static_cast<std::uint16_t>(sides_[t].fan | convex);
}

// Two triangles whose sectors at the vertex are certainly apart leave each other walkable, unless one of them repeats a vertex.
std::size_t SurfaceAdjacency::compare_at(std::uint32_t vertex, std::span<const std::uint32_t> around, std::span<const Vec3> vertices,
                                         std::span<const Triangle> triangles, double margin) {
  const auto is_any = [&](auto&& is) { return std::any_of(around.begin(), around.end(), is); };
  if (!is_any([&](std::uint32_t t) { return is_walkable(t); })) return 0;
  if (is_any([&](std::uint32_t t) { return repeats_vertex(triangles[t]); })) {
    for (const std::uint32_t t : around) mark_unwalkable(t);
    return 0;
  }
  std::vector<NearSectors::Edges> sectors;
  sectors.reserve(around.size());
  for (const std::uint32_t t : around) {
    const Triangle& corner = triangles[t];
    const int k = corner[0] == vertex ? 0 : corner[1] == vertex ? 1 : 2;
    sectors.push_back({vertices[corner[(k + 1) % 3]] - vertices[vertex], vertices[corner[(k + 2) % 3]] - vertices[vertex]});
  }
  std::size_t tests = 0;
  NearSectors(sectors, kMinAngle).visit_pairs([&](std::uint32_t i, std::uint32_t j) {
    const std::uint32_t s = around[i];
    const std::uint32_t t = around[j];
    ++tests;
    if ((sides_[s].is_walkable | sides_[t].is_walkable) == 0 || is_pair_walkable(vertices, triangles[s], triangles[t], margin)) return;
    mark_unwalkable(s);
    mark_unwalkable(t);
  });
  return tests;
}

std::size_t SurfaceAdjacency::find_walkable(std::span<const Vec3> vertices, std::span<const Triangle> triangles, const WideBvh& tree,
                                            double margin) {
  Fans found = find_fans(vertices, triangles);
  const std::vector<Fan>& fans = found.of_vertex;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const Triangle& corner = triangles[t];
    bool is_manifold = !repeats_vertex(corner);
    for (int k = 0; k < 3 && is_manifold; ++k) is_manifold = adjacent(t, k).exists && fans[corner[k]] != Fan::broken;
    sides_[t].is_walkable = static_cast<std::uint16_t>(is_manifold && is_high(corners_of(vertices, corner)));
  }
  std::size_t tests = compare_in_large_fans(vertices, triangles, margin, found);
  const auto has_settled = [&](std::uint32_t v) { return fans[v] == Fan::even || fans[v] == Fan::compared; };
  // Triangles with a common vertex need no test if its fan is even, as those of an even fan are apart, or if its triangles were compared.
  BeyondPlane beyond(vertices, triangles);
  std::array<std::uint32_t, WideBvh::kWidth> lane_items;
  struct Corners8 {
    Uint32x8 first, second, third;
  } of_items;
  tree.for_each_near_pair(
      margin,
      [&](const std::array<std::uint32_t, WideBvh::kWidth>& items, unsigned lanes) {
        lane_items = items;
        beyond.start(items, lanes);
        alignas(32) std::array<std::array<std::uint32_t, WideBvh::kWidth>, 3> corner;
        for (int c = 0; c < WideBvh::kWidth; ++c) {
          const Triangle& triangle = triangles[(lanes >> c & 1U) != 0 ? items[c] : 0];
          for (int k = 0; k < 3; ++k) corner[k][c] = triangle[k];
        }
        const auto load = [&](int k) { return Uint32x8::load(corner[k].data()); };
        of_items = {load(0), load(1), load(2)};
      },
      [&](std::uint32_t t, unsigned near) {
        Uint32x8 settled = Uint32x8(0U);
        for (const std::uint32_t v : triangles[t]) {
          const Uint32x8 vertex = Uint32x8(has_settled(v) ? v : kNone);
          settled = settled | (of_items.first == vertex);
          settled = settled | (of_items.second == vertex);
          settled = settled | (of_items.third == vertex);
        }
        near &= ~sign_bits(settled);
        if (near != 0) near &= ~beyond.find(t, margin);
        for (; near != 0; near &= near - 1) {
          const std::uint32_t u = lane_items[std::countr_zero(near)];
          ++tests;
          if ((sides_[t].is_walkable | sides_[u].is_walkable) == 0 || is_pair_walkable(vertices, triangles[t], triangles[u], margin))
            continue;
          sides_[t].is_walkable = 0;
          sides_[u].is_walkable = 0;
        }
      });
  return tests;
}

}  // namespace hapton
