#include "core/collision/near_triangles.h"

#include <algorithm>
#include <cmath>

namespace hapton {
namespace {

// Rounding bound of a plane's distance in TouchGeometry's local units, for a centre at most 2^6 units out: three products of a unit vector
// and a length, each rounded by 2^-53, and their sums.
constexpr double kRounding = 0x1p-44;

using Lanes3 = std::array<Double4, 3>;
struct alignas(32) Lanes {
  double v[4];
};

[[gnu::always_inline]] inline Double4 dot(const Lanes3& a, const Lanes3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

[[gnu::always_inline]] inline Lanes3 cross(const Lanes3& a, const Lanes3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

[[gnu::always_inline]] inline Lanes3 minus(const Lanes3& a, const Lanes3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

// 1 / x; for x too small for that, a large number.
double inverse(double x) {
  constexpr double kLeast = 0x1p-900;
  return 1.0 / std::max(x, kLeast);
}

// The vector from the closest point of an edge to the query point. `from`: the same vector from the edge's start.
[[gnu::always_inline]] inline Lanes3 from_edge(const Lanes3& from, const Lanes3& edge) {
  const Double4 ahead = dot(from, edge);
  const Double4 squared = dot(edge, edge);
  Lanes t;
  for (int i = 0; i < 4; ++i) t.v[i] = std::clamp(ahead.v[i] * inverse(squared.v[i]), 0.0, 1.0);
  const Double4 at = Double4::load(t.v);
  return {from[0] - at * edge[0], from[1] - at * edge[1], from[2] - at * edge[2]};
}

}  // namespace

// For any unit vector u, the distance of q from the triangle is at least u . (q - x), where x is the triangle's point farthest along u. A u
// with a rounding error, or from the wrong feature of the triangle, weakens the bound and never makes it wrong.
void NearTriangles::bound(const Corners& corners, Bounds& bounds) noexcept {
  const Double4 zero(0.0);
  Lanes3 ap;
  Lanes3 ab;
  Lanes3 ac;
  for (int k = 0; k < 3; ++k) {
    ap[k] = zero - Double4::load(corners.to_a[k]);
    ab[k] = Double4::load(corners.ab[k]);
    ac[k] = Double4::load(corners.ac[k]);
  }
  const Lanes3 bp = minus(ap, ab);
  const Lanes3 bc = minus(ac, ab);
  // From the three edges, and from the face, which is closest where the centre is inside the prism over it.
  const Lanes3 away[4] = {from_edge(ap, ab), from_edge(ap, ac), from_edge(bp, bc), cross(ab, ac)};
  const Lanes3& normal = away[3];
  const Double4 squared[4] = {dot(away[0], away[0]), dot(away[1], away[1]), dot(away[2], away[2]), dot(normal, normal)};
  const Lanes3 sideways = cross(ap, normal);
  const Double4 inside = min(min(dot(sideways, ab), dot(cross(bp, normal), bc)), zero - dot(sideways, ac));
  const Double4 height = dot(normal, ap);
  for (int i = 0; i < 4; ++i) {
    const bool is_inside = inside.v[i] > 0.0;
    int nearest = squared[1].v[i] < squared[0].v[i] ? 1 : 0;
    if (squared[2].v[i] < squared[nearest].v[i]) nearest = 2;
    if (is_inside) nearest = 3;
    const double unit = std::sqrt(inverse(squared[nearest].v[i])) * (is_inside && height.v[i] < 0.0 ? -1.0 : 1.0);
    for (int k = 0; k < 3; ++k) bounds.normal[k][i] = unit * away[nearest][k].v[i];
  }
  Lanes3 u;
  for (int k = 0; k < 3; ++k) u[k] = Double4::load(bounds.normal[k]);
  // The support of the triangle along u, relative to corner a: zero, or one of the two edges.
  const Double4 support = min(zero, min(zero - dot(u, ab), zero - dot(u, ac)));
  const Double4 distance = dot(u, ap) + support - Double4(kRounding);
  for (int i = 0; i < 4; ++i) bounds.distance[i] = distance.v[i];
}

// In batches, so that the memory of several triangles is prefetched at a time.
bool NearTriangles::gather(const TouchGeometry& geometry, const Vec3& centre, double within, int& queried, int most) noexcept {
  geometry_ = &geometry;
  centre_ = centre;
  within_ = within;
  count_ = 0;
  Batch batch;
  int waiting = 0;
  bool fits = true;
  geometry.for_each_within(centre, within, [&](std::uint32_t triangle) {
    geometry.prefetch_indices(triangle);
    batch[static_cast<std::size_t>(waiting++)] = triangle;
    if (waiting == kBatch) {
      queried += waiting;
      fits = add(batch, waiting, most);
      waiting = 0;
    }
    return fits;
  });
  queried += waiting;
  if (fits) fits = add(batch, waiting, most);
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
    Corners corners;
    Bounds bounds;
    for (int lane = 0; lane < 4; ++lane) {
      const ObjectGeometry::Corners of = geometry_->corners(batch[static_cast<std::size_t>(first + std::min(lane, lanes - 1))]);
      for (int k = 0; k < 3; ++k) {
        corners.to_a[k][lane] = of.a[k] - centre_[k];
        corners.ab[k][lane] = of.b[k] - of.a[k];
        corners.ac[k][lane] = of.c[k] - of.a[k];
      }
    }
    bound(corners, bounds);
    for (int lane = 0; lane < lanes; ++lane) {
      if (bounds.distance[lane] > within_ - kRounding) continue;
      if (count_ == most) return false;
      distance_[count_] = bounds.distance[lane];
      for (int k = 0; k < 3; ++k) normal_[k][count_] = bounds.normal[k][lane];
      triangle_[count_] = batch[static_cast<std::size_t>(first + lane)];
      is_prepared_[count_] = false;
      ++count_;
    }
  }
  return true;
}

}  // namespace hapton
