#include "core/collision/near_triangles.h"

#include <bit>

namespace hapton {
namespace {

// Of a bound in TouchGeometry's local units, wherever in kFar scenes the centre is: three products of a unit vector and a length of at
// most 2^6, rounded by 2^-53 each, and their sums.
constexpr double kRounding = 0x1p-44;

using Lanes = std::array<Double4, 3>;

[[gnu::always_inline]] inline Double4 dot(const Lanes& u, const Lanes& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }

[[gnu::always_inline]] inline Lanes cross(const Lanes& u, const Lanes& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

[[gnu::always_inline]] inline Lanes minus(const Lanes& u, const Lanes& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }

// 1 / x, and 0 where x is too small for that.
[[gnu::always_inline]] inline Double4 inverse(Double4 x) {
  constexpr double kLeast = 0x1p-900;
  return (Double4(1.0) / x) & (Double4(kLeast) < x);
}

// From the nearest point of an edge, which begins at `from` away from the query; its squared length is returned.
[[gnu::always_inline]] inline Double4 off_edge(const Lanes& from, const Lanes& edge, Lanes& off) {
  const Double4 t = min(max(dot(from, edge) * inverse(dot(edge, edge)), Double4(0.0)), Double4(1.0));
  for (int k = 0; k < 3; ++k) off[k] = from[k] - t * edge[k];
  return dot(off, off);
}

}  // namespace

// Four triangles at once. The distance from q is at least u . (q - x) for the x of the triangle that is farthest along u, whatever the
// unit vector u: one that is a little off, or of the wrong part of the triangle, weakens the bound and never makes it false.
void NearTriangles::bound(const Corners& corners, Bounds& bounds) noexcept {
  Lanes a;
  Lanes ab;
  Lanes ac;
  for (int k = 0; k < 3; ++k) {
    a[k] = Double4::load(corners.to_a[k]);
    ab[k] = Double4::load(corners.ab[k]);
    ac[k] = Double4::load(corners.ac[k]);
  }
  const Double4 zero(0.0);
  Lanes ap;
  for (int k = 0; k < 3; ++k) ap[k] = zero - a[k];
  const Lanes bp = minus(ap, ab);
  const Lanes bc = minus(ac, ab);
  Lanes off;
  Lanes other;
  Double4 best = off_edge(ap, ab, off);
  for (const bool is_last : {false, true}) {
    const Double4 squared = is_last ? off_edge(bp, bc, other) : off_edge(ap, ac, other);
    const Double4 is_nearer = squared < best;
    for (int k = 0; k < 3; ++k) off[k] = select(is_nearer, other[k], off[k]);
    best = min(squared, best);
  }
  const Double4 inverse_length = sqrt(inverse(best));
  for (int k = 0; k < 3; ++k) off[k] = off[k] * inverse_length;

  // Inside the prism over the triangle the face is nearest.
  const Lanes normal = cross(ab, ac);
  const Lanes turned = cross(ap, normal);
  const Double4 is_inside = (zero < dot(turned, ab)) & (zero < dot(cross(bp, normal), bc)) & (dot(turned, ac) < zero);
  const Double4 inverse_area = sqrt(inverse(dot(normal, normal)));
  const Double4 towards = select(dot(normal, ap), zero - inverse_area, inverse_area);
  for (int k = 0; k < 3; ++k) off[k] = select(is_inside, normal[k] * towards, off[k]);

  const Double4 support = max(zero, max(dot(off, ab), dot(off, ac)));
  store(bounds.distance, dot(off, ap) - support - Double4(kRounding));
  for (int k = 0; k < 3; ++k) store(bounds.normal[k], off[k]);
}

// In batches: while the memory of one triangle is on its way, that of the next is asked for.
bool NearTriangles::gather(const TouchGeometry& geometry, const Vec3& centre, double within, int& looked_at) noexcept {
  geometry_ = &geometry;
  centre_ = centre;
  within_ = within;
  count_ = 0;
  Batch batch;
  int waiting = 0;
  bool fits = true;
  geometry.for_each_overlapping(Box{centre, centre}.inflated(within), [&](std::uint32_t triangle) {
    geometry.prefetch_indices(triangle);
    batch[static_cast<std::size_t>(waiting++)] = triangle;
    if (waiting == kBatch) {
      looked_at += waiting;
      fits = add(batch, waiting);
      waiting = 0;
    }
    return fits;
  });
  looked_at += waiting;
  if (fits) fits = add(batch, waiting);
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

bool NearTriangles::add(const Batch& batch, int count) noexcept {
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
      if (count_ == kCapacity) return false;
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
