#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/collision/fdh_tree.h"

namespace hapton {

// The two levels of the FDH paper, section 3: a hierarchy of Fixed Direction Hulls over the objects, and under each object the tree
// over its triangles. Frame: one for all objects (static scene S). Units: the meshes'. Threads: const calls from any number. RT: queries
// yes; build and refit set-up only.
template <int K>
class FdhScene {
 public:
  struct Object {
    std::span<const Vec3> vertices;
    std::span<const Triangle> triangles;
  };

  FdhScene() = default;

  // Pre: the vertices outlive the scene. Objects without triangles are allowed and never found. Error: as FdhTree::build.
  static Result<FdhScene> build(std::span<const Object> objects);

  // Updates an object's tree and the upper level after its vertices have moved. Pre, Error: see FdhTree::refit; an error changes nothing.
  Result<void> refit(std::uint32_t object, std::span<const Vec3> vertices);

  // Calls visit(object, triangle) for every triangle that the query touches, as FdhTree does. Query: FdhBall or FdhSweep.
  template <class Query, class Visit>
  FdhVisits for_each_overlapping(const Query& query, Visit&& visit) const;

  // Adds the triangles nearest to the segment between two points (or to one point, if they are equal) to `nearest`.
  FdhVisits collect_nearest(const Vec3& from, const Vec3& to, FdhNearest& nearest) const;

  std::size_t object_count() const { return trees_.size(); }
  const FdhTree<K>& tree(std::size_t object) const { return trees_[object]; }
  FdhStats stats() const {
    FdhStats all{0, upper_.node_count(), upper_.depth(), upper_.bytes() + order_.capacity() * sizeof(std::uint32_t)};
    for (const FdhTree<K>& tree : trees_) {
      const FdhStats one = tree.stats();
      all.triangles += one.triangles;
      all.nodes += one.nodes;
      all.depth = std::max(all.depth, upper_.depth() + one.depth);
      all.bytes += one.bytes;
    }
    return all;
  }

 private:
  void measure();
  void set_planes();
  FdhInterval<K> interval(const FdhHull<K>& hull) const;

  FdhHierarchy<K> upper_;
  std::vector<std::uint32_t> order_;
  std::vector<FdhTree<K>> trees_;
  Vec3 centre_ = Vec3::Zero();
  double rounding_ = 0.0;  // how far rounding can move a computed point or distance, for queries within the scene's extent
};

// ---------------------------------------------------------------------------------------------------------------------

template <int K>
void FdhScene<K>::measure() {
  FdhHull<K> all;
  double tree_rounding = 0.0;
  for (const FdhTree<K>& tree : trees_) {
    if (tree.stats().triangles == 0) continue;
    for (int i = 0; i < K / 2; ++i) {
      all.low[i] = std::min(all.low[i], tree.hull().low[i]);
      all.high[i] = std::max(all.high[i], tree.hull().high[i]);
    }
    tree_rounding = std::max(tree_rounding, tree.rounding());
  }
  if (!(all.low[0] <= all.high[0])) return;
  double largest = 0.0;
  for (int i = 0; i < 3; ++i) {
    centre_[i] = 0.5 * all.low[i] + 0.5 * all.high[i];
    largest = std::max({largest, std::fabs(all.low[i]), std::fabs(all.high[i])});
  }
  rounding_ = tree_rounding + 0x1p-48 * largest;
}

template <int K>
void FdhScene<K>::set_planes() {
  const auto middle = fdh_project<K>(centre_);
  upper_.refit(rounding_ * 3.0, [&](std::uint32_t first, std::uint32_t count) {
    FdhHull<K> hull;
    for (std::uint32_t i = first; i < first + count; ++i) {
      const FdhHull<K>& one = trees_[order_[i]].hull();
      for (int k = 0; k < K / 2; ++k) {
        hull.low[k] = std::min(hull.low[k], one.low[k] - middle[k]);
        hull.high[k] = std::max(hull.high[k], one.high[k] - middle[k]);
      }
    }
    return hull;
  });
}

template <int K>
Result<FdhScene<K>> FdhScene<K>::build(std::span<const Object> objects) {
  // Objects may be farther apart than a float reaches; boxes of items only decide how the tree is split, so the farthest may coincide.
  const auto to_item = [](double x) { return static_cast<float>(std::clamp(x, -1e37, 1e37)); };
  FdhScene scene;
  std::vector<FdhItem> items;
  for (std::size_t o = 0; o < objects.size(); ++o) {
    auto tree = FdhTree<K>::build(objects[o].vertices, objects[o].triangles);
    if (!tree) return fail("object {}: {}", o, tree.error().what);
    scene.trees_.push_back(std::move(*tree));
  }
  scene.measure();
  for (std::size_t o = 0; o < objects.size(); ++o) {
    const FdhTree<K>& tree = scene.trees_[o];
    if (tree.stats().triangles == 0) continue;
    FdhItem item{{}, static_cast<std::uint32_t>(o), {}};
    for (int k = 0; k < 3; ++k) {
      item.low[k] = to_item(tree.hull().low[k] - scene.centre_[k]);
      item.high[k] = to_item(tree.hull().high[k] - scene.centre_[k]);
    }
    items.push_back(item);
  }
  FdhTopology topology = build_fdh_topology(items);
  scene.order_ = std::move(topology.order);
  scene.upper_.adopt(topology);
  scene.set_planes();
  return scene;
}

template <int K>
Result<void> FdhScene<K>::refit(std::uint32_t object, std::span<const Vec3> vertices) {
  if (object >= trees_.size()) return fail("scene: there is no object {}; it has {}", object, trees_.size());
  if (const auto moved = trees_[object].refit(vertices); !moved) return moved;
  measure();
  set_planes();
  return {};
}

template <int K>
FdhInterval<K> FdhScene<K>::interval(const FdhHull<K>& hull) const {
  const auto middle = fdh_project<K>(centre_);
  FdhInterval<K> q;
  for (int i = 0; i < K / 2; ++i) {
    const double pad = 4.0 * rounding_ + 0x1p-48 * (std::fabs(hull.low[i]) + std::fabs(hull.high[i]));
    q.low[i] = detail::float_below(hull.low[i] - middle[i] - pad);
    q.high[i] = detail::float_above(hull.high[i] - middle[i] + pad);
  }
  return q;
}

namespace detail {

// The hull around a query: objects that do not overlap this hull are skipped.
template <int K>
FdhHull<K> hull_around(const FdhSweep& sweep) {
  FdhHull<K> hull;
  hull.add(sweep.from);
  hull.add(sweep.to);
  for (int i = 0; i < K / 2; ++i) {
    const double grow = sweep.radius * std::sqrt(static_cast<double>(FdhDirections<K>::length_squared(i))) * (1.0 + kOutward);
    hull.low[i] -= grow;
    hull.high[i] += grow;
  }
  return hull;
}
template <int K>
FdhHull<K> hull_around(const FdhBall& ball) {
  return hull_around<K>(FdhSweep{ball.centre, ball.centre, ball.radius});
}

}  // namespace detail

template <int K>
template <class Query, class Visit>
FdhVisits FdhScene<K>::for_each_overlapping(const Query& query, Visit&& visit) const {
  FdhHull<K> hull = detail::hull_around<K>(query);
  for (int i = 0; i < K / 2; ++i) {
    if (!(hull.low[i] <= hull.high[i])) return {};
  }
  FdhVisits below;
  FdhVisits visits = upper_.walk_overlapping(interval(hull), [&](std::uint32_t first, std::uint32_t count) {
    for (std::uint32_t i = first; i < first + count; ++i) {
      const std::uint32_t object = order_[i];
      below += trees_[object].for_each_overlapping(query, [&](std::uint32_t triangle) { visit(object, triangle); });
    }
  });
  return visits += below;
}

template <int K>
FdhVisits FdhScene<K>::collect_nearest(const Vec3& from, const Vec3& to, FdhNearest& nearest) const {
  FdhHull<K> path;
  path.add(from);
  path.add(to);
  FdhVisits below;
  FdhVisits visits = upper_.walk_nearest(
      interval(path), [&nearest] { return nearest.bound_squared(); },
      [&](std::uint32_t first, std::uint32_t count) {
        for (std::uint32_t i = first; i < first + count; ++i) below += trees_[order_[i]].collect_nearest(from, to, order_[i], nearest);
      });
  return visits += below;
}

}  // namespace hapton
