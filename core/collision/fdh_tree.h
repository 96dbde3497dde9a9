#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/collision/box.h"
#include "core/collision/fdh_hierarchy.h"
#include "core/geometry/triangle_distance.h"
#include "core/geometry/triangle_mesh.h"

namespace hapton {

// Relative widening of bounds, in the direction in which nothing is missed. A few operations on doubles round by 2^-53 each.
constexpr double kOutward = 0x1p-40;
// The largest extent, half a mesh's longest side, in its unit; the inverse is the smallest above 0. Squares of extents (1e30 and 1e-30)
// stay far inside the range of a float.
constexpr double kLargestExtent = 1e15;
// The hierarchy is searched for sweeps whose ends are at most this far, along each axis, from the mesh's middle: 1e15 times the largest
// extent. There neither a coordinate nor the inverse of a length leaves the range of a float.
constexpr double kFarthestSweep = 1e30;

struct FdhBall {
  Vec3 centre;
  double radius;
};
// A ball moved from one point to another: a segment if the radius is 0; a ball if the points are equal.
struct FdhSweep {
  Vec3 from;
  Vec3 to;
  double radius = 0.0;
};

// One triangle and its distance. Not initialized: queries keep hundreds of them on the stack.
struct FdhNear {
  double distance_squared;
  std::uint32_t triangle;
  std::uint32_t object;
};
constexpr FdhNear kNothingNear = {std::numeric_limits<double>::infinity(), 0, 0};

// Collects the nearest triangles, one more than requested: the distance of that one bounds the distance within which the result is
// complete. Candidates fill a buffer; when it is full, a selection keeps the nearest, so each costs constant time on average. RT: yes.
class FdhNearest {
 public:
  static constexpr std::size_t kMaxCount = 256;  // as LocalSet::kCapacity

  // Pre: 1 <= count <= kMaxCount, max_distance >= 0 (infinite: no limit).
  FdhNearest(std::size_t count, double max_distance)
      : keep_count_(count + 1), bound_squared_(max_distance * max_distance), max_distance_(max_distance) {}

  double bound_squared() const { return bound_squared_; }
  std::size_t count() const { return count_; }  // candidates in the buffer, or after finish() the result's
  // Tells how large the rounding error of the distances that are added may be; the largest value counts.
  void allow_rounding(double rounding) { rounding_ = rounding > rounding_ ? rounding : rounding_; }
  void add(double distance_squared, std::uint32_t object, std::uint32_t triangle) {
    if (!(distance_squared <= bound_squared_)) return;
    candidates_[count_++] = {distance_squared, triangle, object};
    if (count_ == limit()) keep_nearest();
  }

  // Ends the search and returns the triangles found, in no order: all nearer than complete_radius().
  std::span<const FdhNear> finish() {
    double searched = max_distance_;
    if (count_ >= keep_count_) {
      keep_nearest();
      searched = std::sqrt(candidates_[keep_count_ - 1].distance_squared);
      count_ = keep_count_ - 1;
    }
    complete_radius_ = std::fmax(0.0, searched * (1.0 - kOutward) - 2.0 * rounding_);
    return {candidates_.data(), count_};
  }
  double complete_radius() const { return complete_radius_; }

 private:
  static bool is_nearer(const FdhNear& a, const FdhNear& b) {
    if (a.distance_squared != b.distance_squared) return a.distance_squared < b.distance_squared;
    return a.object != b.object ? a.object < b.object : a.triangle < b.triangle;
  }
  // The buffer is reduced when it holds half as many again as are kept: a smaller one costs more selections, a larger one more tests of
  // triangles that are too far away (bench/fdh_bench.cpp).
  std::size_t limit() const { return keep_count_ + keep_count_ / 2 + 1; }
  // Keeps the nearest keep_count_; the farthest of them is last and is the new bound.
  void keep_nearest() {
    std::nth_element(candidates_.begin(), candidates_.begin() + (keep_count_ - 1), candidates_.begin() + count_,
                     [](const FdhNear& a, const FdhNear& b) { return is_nearer(a, b); });
    count_ = keep_count_;
    bound_squared_ = candidates_[keep_count_ - 1].distance_squared;
  }

  std::size_t keep_count_;
  std::size_t count_ = 0;
  double bound_squared_;
  double max_distance_;
  double complete_radius_ = 0.0;
  double rounding_ = 0.0;
  std::array<FdhNear, 2 * (kMaxCount + 1)> candidates_;  // the first count_ are valid
};

// Statistics of a tree.
struct FdhStats {
  std::size_t triangles = 0;
  std::size_t nodes = 0;
  int depth = 0;
  std::size_t bytes = 0;  // of the tree, without the mesh, which its owner keeps
};

// The second level of the FDH paper, section 3: the triangles of one object in a hierarchy of Fixed Direction Hulls. K: 6 (axis-aligned
// boxes), 14 (the paper's), 18, 26. Coordinates are taken relative to the middle of the mesh, in double, before they become single
// precision planes, so distant and tiny meshes need no special treatment. Frames: the mesh's. Units: the mesh's. Threads: const calls from
// any number. RT: queries yes; build, refit set-up only (refit uses no heap).
template <int K>
class FdhTree {
 public:
  FdhTree() = default;

  // Pre: the vertices outlive the tree; indices are in range, coordinates finite.
  // Error: more than 2^28 triangles; a longest side above 2e15, or below 2e-15 but not 0.
  static Result<FdhTree> build(std::span<const Vec3> vertices, std::span<const Triangle> triangles);

  // Moves the triangles' vertices. Only planes are recomputed: after a large change of shape a new build gives faster queries. Pre: as many
  // vertices as before; they outlive the tree. Error: see build; the tree is then unchanged.
  Result<void> refit(std::span<const Vec3> vertices);

  // Each calls visit(triangle) once for every triangle at most the radius away. A sweep of radius 0 visits all triangles in leaves whose
  // hull it meets; a sweep that reaches beyond kFarthestSweep visits every triangle of the tree. Rounding only adds triangles, never drops
  // one. Nothing is visited if a point is not finite, or the radius negative or not a number; it may be infinite.
  template <class Visit>
  FdhVisits for_each_overlapping(const FdhBall& ball, Visit&& visit) const;
  template <class Visit>
  FdhVisits for_each_overlapping(const FdhSweep& sweep, Visit&& visit) const;

  // The triangle nearest to p (of equally near ones that with the lowest number); kNothingNear if none is at most max_distance away.
  FdhNear find_nearest(const Vec3& p, double max_distance = std::numeric_limits<double>::infinity()) const;

  // Adds the triangles nearest to a point, or to the segment between two points, to `nearest`, with the number of their object.
  FdhVisits collect_nearest(const Vec3& p, std::uint32_t object, FdhNearest& nearest) const;
  FdhVisits collect_nearest(const Vec3& from, const Vec3& to, std::uint32_t object, FdhNearest& nearest) const;

  // Calls visit(hull, triangles) for every hull of the tree at depth `level` (FdhHierarchy); the hull is in the mesh's frame. RT: no.
  template <class Visit>
  void for_each_hull(int level, Visit&& visit) const {
    const auto middle = fdh_project<K>(centre_);
    hierarchy_.for_each_hull(level, [&](FdhHull<K> hull, std::uint32_t first, std::uint32_t count) {
      for (int i = 0; i < K / 2; ++i) {
        hull.low[i] += middle[i];
        hull.high[i] += middle[i];
      }
      visit(hull, std::span(order_).subspan(first, count));
    });
  }

  FdhStats stats() const {
    return {order_.size(), hierarchy_.node_count(), hierarchy_.depth(),
            hierarchy_.bytes() + order_.capacity() * sizeof(std::uint32_t) + corners_.capacity() * sizeof(Triangle)};
  }
  const FdhHull<K>& hull() const { return hull_; }  // of all triangles, in the mesh's frame
  // How far rounding can move a point or a distance that this tree computes, for queries within the mesh's extent.
  double rounding() const { return rounding_; }

 private:
  using Points4 = detail::Of3<Lanes4>;

  FdhInterval<K> interval(const Vec3& p, const Vec3& q) const;
  // Calls use(id, squared distance) for each triangle of a leaf. distance_of: computes it for four triangles, given their corners in lanes.
  template <class DistanceOf, class Use>
  void measure_leaf(std::uint32_t first, std::uint32_t count, DistanceOf&& distance_of, Use&& use) const;
  template <class DistanceOf>
  FdhVisits collect(const FdhInterval<K>& q, const DistanceOf& distance_of, std::uint32_t object, FdhNearest& nearest) const;
  FdhHull<K> hull_of(std::uint32_t first, std::uint32_t count, const Vec3& origin) const;
  Result<void> measure(std::span<const Vec3> vertices, std::span<const Triangle> triangles);
  void set_planes();
  // Bound on the error of a distance computed from p.
  double rounding_at(const Vec3& p) const { return rounding_ + 0x1p-49 * (p - centre_).cwiseAbs().maxCoeff(); }
  // The square of the radius, after adding what rounding may add to a distance.
  double bound_squared_at(double radius, const Vec3& p) const {
    const double bound = radius * (1.0 + kOutward) + rounding_at(p);
    return bound * bound;
  }

  FdhHierarchy<K> hierarchy_;
  std::vector<std::uint32_t> order_;
  std::vector<Triangle> corners_;  // in tree order
  std::span<const Vec3> vertices_;
  FdhHull<K> hull_;
  Vec3 centre_ = Vec3::Zero();
  double extent_ = 0.0;  // largest distance from the centre along a coordinate
  double rounding_ = 0.0;
};

// ---------------------------------------------------------------------------------------------------------------------

template <int K>
Result<void> FdhTree<K>::measure(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  Box box;
  for (const Triangle& triangle : triangles) {
    for (const std::uint32_t index : triangle) box.grow(vertices[index]);
  }
  const auto& [low, high] = triangles.empty() ? Box{Vec3::Zero(), Vec3::Zero()} : box;
  const double extent = 0.5 * (high - low).maxCoeff();
  if (!(extent < kLargestExtent) || (extent > 0.0 && extent < 1.0 / kLargestExtent)) {
    return fail("tree: the mesh extends {:g} m; give coordinates in metres, between 2e-15 and 2e15 across", 2.0 * extent);
  }
  extent_ = extent;
  centre_ = 0.5 * low + 0.5 * high;
  // Projections add three coordinates: a few units of 2^-53 of the coordinates themselves (the rounding of p - centre) and of extents.
  const double largest = std::max(low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff());
  rounding_ = 0x1p-50 * (extent + largest);
  return {};
}

template <int K>
Result<FdhTree<K>> FdhTree<K>::build(std::span<const Vec3> vertices, std::span<const Triangle> triangles) {
  if (triangles.size() > FdhTopology::kMaxItems) {
    return fail("tree: {} triangles are more than the {} a tree can hold; split the mesh into objects", triangles.size(),
                FdhTopology::kMaxItems);
  }
  FdhTree tree;
  if (const auto measured = tree.measure(vertices, triangles); !measured) return tl::unexpected(measured.error());
  const double scale = tree.extent_ > 0.0 ? 1.0 / tree.extent_ : 1.0;
  std::vector<FdhItem> items(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Vec3 a = (vertices[triangles[i][0]] - tree.centre_) * scale;
    const Vec3 b = (vertices[triangles[i][1]] - tree.centre_) * scale;
    const Vec3 c = (vertices[triangles[i][2]] - tree.centre_) * scale;
    const Eigen::Vector3f low = a.cwiseMin(b).cwiseMin(c).template cast<float>();
    const Eigen::Vector3f high = a.cwiseMax(b).cwiseMax(c).template cast<float>();
    items[i] = {{low.x(), low.y(), low.z()}, static_cast<std::uint32_t>(i), {high.x(), high.y(), high.z()}};
  }
  FdhTopology topology = build_fdh_topology(items);
  tree.order_ = std::move(topology.order);
  tree.corners_.resize(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) tree.corners_[i] = triangles[tree.order_[i]];
  tree.hierarchy_.adopt(topology);
  tree.vertices_ = vertices;
  tree.set_planes();
  return tree;
}

template <int K>
Result<void> FdhTree<K>::refit(std::span<const Vec3> vertices) {
  if (vertices.size() != vertices_.size()) {
    return fail("tree: {} vertices instead of {}; build a new tree when the mesh itself changes", vertices.size(), vertices_.size());
  }
  if (const auto measured = measure(vertices, corners_); !measured) return measured;
  vertices_ = vertices;
  set_planes();
  return {};
}

template <int K>
void FdhTree<K>::set_planes() {
  hierarchy_.refit(rounding_ * 3.0, [this](std::uint32_t first, std::uint32_t count) { return hull_of(first, count, centre_); });
  hull_ = hull_of(0, static_cast<std::uint32_t>(order_.size()), Vec3::Zero());
}

template <int K>
FdhHull<K> FdhTree<K>::hull_of(std::uint32_t first, std::uint32_t count, const Vec3& origin) const {
  FdhHull<K> hull;
  for (std::uint32_t i = first; i < first + count; ++i) {
    for (const std::uint32_t index : corners_[i]) hull.add(vertices_[index] - origin);
  }
  return hull;
}

template <int K>
FdhInterval<K> FdhTree<K>::interval(const Vec3& p, const Vec3& q) const {
  const auto a = fdh_project<K>(p - centre_);
  const auto b = fdh_project<K>(q - centre_);
  FdhInterval<K> out;
  for (int i = 0; i < K / 2; ++i) {
    const double pad = 0x1p-50 * (std::fabs(a[i]) + std::fabs(b[i]));
    out.low[i] = detail::float_below(std::min(a[i], b[i]) - pad);
    out.high[i] = detail::float_above(std::max(a[i], b[i]) + pad);
  }
  return out;
}

template <int K>
template <class DistanceOf, class Use>
void FdhTree<K>::measure_leaf(std::uint32_t first, std::uint32_t count, DistanceOf&& distance_of, Use&& use) const {
  // All lanes at once: stores lane by lane would stall the vector load that follows (store forwarding). Lanes beyond count repeat the last
  // triangle.
  const std::array<const Triangle*, 4> t = {&corners_[first], &corners_[first + std::min(1U, count - 1)],
                                            &corners_[first + std::min(2U, count - 1)], &corners_[first + count - 1]};
  const auto gather = [&](std::size_t k) {
    const double* p0 = vertices_[(*t[0])[k]].data();
    const double* p1 = vertices_[(*t[1])[k]].data();
    const double* p2 = vertices_[(*t[2])[k]].data();
    const double* p3 = vertices_[(*t[3])[k]].data();
    return Points4{Lanes4{p0[0], p1[0], p2[0], p3[0]}, Lanes4{p0[1], p1[1], p2[1], p3[1]}, Lanes4{p0[2], p1[2], p2[2], p3[2]}};
  };
  const Lanes4 d = distance_of(gather(0), gather(1), gather(2));
  for (std::uint32_t i = 0; i < count; ++i) use(order_[first + i], d[i]);
}

namespace detail {
inline Of3<Lanes4> lanes_of(const Vec3& p) { return {Lanes4{} + p.x(), Lanes4{} + p.y(), Lanes4{} + p.z()}; }

// Functions for FdhTree::measure_leaf, which compute the squared distances of four triangles from a point, or from a segment.
inline auto distance_from(const Vec3& p) {
  return [p = lanes_of(p)](const Of3<Lanes4>& a, const Of3<Lanes4>& b, const Of3<Lanes4>& c) {
    return triangle_distance_squared<Lanes4>(p, a, b, c);
  };
}
inline auto distance_from(const Vec3& p, const Vec3& q) {
  return [p = lanes_of(p), q = lanes_of(q)](const Of3<Lanes4>& a, const Of3<Lanes4>& b, const Of3<Lanes4>& c) {
    return segment_triangle_distance_squared<Lanes4>(p, q, a, b, c);
  };
}
}  // namespace detail

template <int K>
template <class Visit>
FdhVisits FdhTree<K>::for_each_overlapping(const FdhBall& ball, Visit&& visit) const {
  if (!ball.centre.allFinite() || !(ball.radius >= 0.0)) return {};
  const double bound_squared = bound_squared_at(ball.radius, ball.centre);
  const auto distance_of = detail::distance_from(ball.centre);
  const auto leaf = [&](std::uint32_t first, std::uint32_t count) {
    measure_leaf(first, count, distance_of, [&](std::uint32_t id, double squared) {
      if (squared <= bound_squared) visit(id);
    });
  };
  return hierarchy_.walk_nearest(
      interval(ball.centre, ball.centre), [bound_squared] { return bound_squared; }, leaf);
}

template <int K>
template <class Visit>
FdhVisits FdhTree<K>::for_each_overlapping(const FdhSweep& sweep, Visit&& visit) const {
  if (!sweep.from.allFinite() || !sweep.to.allFinite() || !(sweep.radius >= 0.0)) return {};
  const Vec3 begin = sweep.from - centre_;
  const Vec3 end = sweep.to - centre_;
  if (!(begin.cwiseAbs().cwiseMax(end.cwiseAbs()).maxCoeff() <= kFarthestSweep)) {  // also where a difference overflows
    for (const std::uint32_t id : order_) visit(id);
    return {0, 0, static_cast<std::uint32_t>(order_.size())};
  }
  const double bound_squared = std::max(bound_squared_at(sweep.radius, sweep.from), bound_squared_at(sweep.radius, sweep.to));
  const auto q = FdhHierarchy<K>::make_sweep(fdh_project<K>(begin), fdh_project<K>(end), std::sqrt(bound_squared));
  if (sweep.radius == 0.0) {
    return hierarchy_.walk_swept(q, [&](std::uint32_t first, std::uint32_t count) {
      for (std::uint32_t i = first; i < first + count; ++i) visit(order_[i]);
    });
  }
  const auto distance_of = detail::distance_from(sweep.from, sweep.to);
  return hierarchy_.walk_swept(q, [&](std::uint32_t first, std::uint32_t count) {
    measure_leaf(first, count, distance_of, [&](std::uint32_t id, double squared) {
      if (squared <= bound_squared) visit(id);
    });
  });
}

template <int K>
FdhNear FdhTree<K>::find_nearest(const Vec3& p, double max_distance) const {
  FdhNear best = kNothingNear;
  if (!p.allFinite() || !(max_distance >= 0.0)) return best;
  double bound_squared = max_distance * max_distance;
  bool found = false;
  const auto distance_of = detail::distance_from(p);
  hierarchy_.walk_nearest(
      interval(p, p), [&bound_squared] { return bound_squared; },
      [&](std::uint32_t first, std::uint32_t count) {
        measure_leaf(first, count, distance_of, [&](std::uint32_t id, double squared) {
          if (!(squared < bound_squared || (squared == bound_squared && (!found || id < best.triangle)))) return;
          bound_squared = squared;
          best = {bound_squared, id, 0};
          found = true;
        });
      });
  return best;
}

template <int K>
template <class DistanceOf>
FdhVisits FdhTree<K>::collect(const FdhInterval<K>& q, const DistanceOf& distance_of, std::uint32_t object, FdhNearest& nearest) const {
  return hierarchy_.walk_nearest(
      q, [&nearest] { return nearest.bound_squared(); },
      [&](std::uint32_t first, std::uint32_t count) {
        measure_leaf(first, count, distance_of, [&](std::uint32_t id, double squared) { nearest.add(squared, object, id); });
      });
}

template <int K>
FdhVisits FdhTree<K>::collect_nearest(const Vec3& p, std::uint32_t object, FdhNearest& nearest) const {
  if (!p.allFinite()) return {};
  nearest.allow_rounding(rounding_at(p));
  return collect(interval(p, p), detail::distance_from(p), object, nearest);
}

template <int K>
FdhVisits FdhTree<K>::collect_nearest(const Vec3& from, const Vec3& to, std::uint32_t object, FdhNearest& nearest) const {
  if (from == to) return collect_nearest(from, object, nearest);
  if (!from.allFinite() || !to.allFinite()) return {};
  nearest.allow_rounding(std::max(rounding_at(from), rounding_at(to)));
  return collect(interval(from, to), detail::distance_from(from, to), object, nearest);
}

}  // namespace hapton
