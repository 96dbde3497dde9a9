#include "core/collision/near_triangles.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// A bound on the rounding error of a distance from a plane, in TouchGeometry's local units, for a centre at most 2^6 units from the origin:
// three products of a component of a unit vector and a length, each rounded by 2^-53, and their sums.
constexpr double kRounding = 0x1p-44;

using Lanes3 = std::array<Double4, 3>;
[[gnu::always_inline]] inline Double4 dot(const Lanes3& a, const Lanes3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

[[gnu::always_inline]] inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

[[gnu::always_inline]] inline Lanes3 minus(const Lanes3& a, const Lanes3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

[[gnu::always_inline]] inline Lanes3 select(const Double4& mask, const Lanes3& set, const Lanes3& clear) {
  return {select(mask, set[0], clear[0]), select(mask, set[1], clear[1]), select(mask, set[2], clear[2])};
}

// 1 / x; if x is too small for that, a large finite number.
[[gnu::always_inline]] inline Double4 inverse(const Double4& x) {
  // The inverse of kMinDivisor is finite. Squared lengths of edges on the grid are 2^-102 or more.
  constexpr double kMinDivisor = 0x1p-900;
  return Double4(1.0) / max(Double4(kMinDivisor), x);
}

// The vector from the closest point of an edge to the query point. `from`: the vector from the edge's start to the query point.
[[gnu::always_inline]] inline Lanes3 from_edge(const Lanes3& from, const Lanes3& edge) {
  const Double4 share = min(Double4(1.0), max(Double4(0.0), dot(from, edge) * inverse(dot(edge, edge))));
  return {from[0] - share * edge[0], from[1] - share * edge[1], from[2] - share * edge[2]};
}

// Element k has coordinate k of all four points, a point in each lane.
[[gnu::always_inline]] inline Lanes3 load_points(const std::array<const Vec3*, 4>& points) {
  std::array<Double4, 4> rows;
  for (std::size_t i = 0; i < 4; ++i) rows[i] = Double4::load_three(points[i]->data());
  transpose(rows[0], rows[1], rows[2], rows[3]);
  return {rows[0], rows[1], rows[2]};
}

}  // namespace

// For any unit vector u, the distance of q from the triangle is at least u . (q - x), where x is the triangle's point farthest along u. A u
// with a rounding error, or from the wrong feature of the triangle, weakens the bound and never makes it wrong.
void NearTriangles::bound(const Corners& corners, const Vec3& centre, Bounds& bounds) noexcept {
  const Double4 zero(0.0);
  const Double4 one(1.0);
  const Lanes3 ap = minus({Double4(centre[0]), Double4(centre[1]), Double4(centre[2])}, corners.a);
  const Lanes3 ab = minus(corners.b, corners.a);
  const Lanes3 ac = minus(corners.c, corners.a);
  const Lanes3 bp = minus(ap, ab);
  const Lanes3 bc = minus(ac, ab);
  // away: the direction from the triangle's closest point, which is on an edge, or on the face if the centre is in the prism over it.
  Lanes3 away = from_edge(ap, ab);
  Double4 squared = dot(away, away);
  const auto take = [&](const Double4& mask, const Lanes3& other, const Double4& other_squared) {
    away = select(mask, other, away);
    squared = select(mask, other_squared, squared);
  };
  for (const Lanes3& other : {from_edge(ap, ac), from_edge(bp, bc)}) {
    const Double4 other_squared = dot(other, other);
    take(other_squared < squared, other, other_squared);
  }
  const Lanes3 normal = cross(ab, ac);
  const Lanes3 sideways = cross(ap, normal);
  const Double4 inside = min(min(dot(sideways, ab), dot(cross(bp, normal), bc)), zero - dot(sideways, ac));
  const Double4 is_inside = zero < inside;
  take(is_inside, normal, dot(normal, normal));
  const Double4 sign = select(is_inside, select(dot(normal, ap) < zero, Double4(-1.0), one), one);
  const Double4 unit = sqrt(inverse(squared)) * sign;
  const Lanes3 u = {unit * away[0], unit * away[1], unit * away[2]};
  // Minus the largest u . (x - corner a) over the points x of the triangle, which a corner reaches.
  const Double4 support = min(zero, min(zero - dot(u, ab), zero - dot(u, ac)));
  store(bounds.distance, dot(u, ap) + support - Double4(kRounding));
  for (std::size_t k = 0; k < 3; ++k) store(bounds.normal[k], u[k]);
}

// Works in batches, so that the memory of several triangles is prefetched at the same time.
bool NearTriangles::gather(const TouchGeometry& geometry, const Vec3& centre, double within, int& queried, int most) noexcept {
  geometry_ = &geometry;
  centre_ = centre;
  radius_ = within;
  count_ = 0;
  outside_fans_ = 0;
  queried_in_fans_ = 0;
  prepared_.fill(-1);
  Batch batch;
  int batch_size = 0;
  int visited = 0;
  bool fits = true;
  geometry.for_each_within(centre, within, [&](std::uint32_t triangle) {
    geometry.prefetch_indices(triangle);
    batch[static_cast<std::size_t>(batch_size++)] = triangle;
    ++(geometry.is_in_large_fan(triangle) ? queried_in_fans_ : visited);
    if (batch_size == kBatch) {
      queried += batch_size;
      fits = visited <= kMaxVisited && queried_in_fans_ <= kMaxVisitedInFans && add(batch, batch_size, most);
      batch_size = 0;
    }
    return fits;
  });
  queried += batch_size;
  if (fits) fits = add(batch, batch_size, most);
  gathered_ = count_;
  if (!fits) {
    clear();
    return false;
  }
  for (int i = count_; i % 4 != 0; ++i) {
    distance_[i] = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) normal_[k][i] = 0.0;
  }
  return true;
}

bool NearTriangles::add(const Batch& batch, int count, int most) noexcept {
  for (int i = 0; i < count; ++i) geometry_->prefetch_corners(batch[static_cast<std::size_t>(i)]);
  for (int first = 0; first < count; first += 4) {
    const int lanes = std::min(4, count - first);
    Bounds bounds;
    std::array<const Vec3*, 4> a, b, c;
    for (std::size_t lane = 0; lane < 4; ++lane) {
      const auto at = static_cast<std::size_t>(first + std::min(static_cast<int>(lane), lanes - 1));
      const ObjectGeometry::Corners corners = geometry_->corners(batch[at]);
      a[lane] = &corners.a;
      b[lane] = &corners.b;
      c[lane] = &corners.c;
    }
    bound({load_points(a), load_points(b), load_points(c)}, centre_, bounds);
    for (int lane = 0; lane < lanes; ++lane) {
      if (bounds.distance[lane] > radius_) continue;
      if (count_ == most) return false;
      if (!geometry_->is_in_large_fan(batch[static_cast<std::size_t>(first + lane)]) && ++outside_fans_ > kMaxOutsideFans) return false;
      distance_[count_] = bounds.distance[lane];
      for (int k = 0; k < 3; ++k) normal_[k][count_] = bounds.normal[k][lane];
      triangle_[count_] = batch[static_cast<std::size_t>(first + lane)];
      ++count_;
    }
  }
  return true;
}

}  // namespace hapton
