#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/collision/box.h"
#include "core/collision/wide_bvh.h"

namespace hapton {

// The upper level over the objects of a scene: a tree over their bounds, so that the cost of a query depends on the objects near it, not on
// the number of objects (FDH paper, section 3; here with axis-aligned boxes). An object may have no bounds (an empty box): no query finds
// it until a refit gives it bounds.
//
// When an object has moved, refit() updates its box and the boxes above it, so queries stay exact. Objects that move far make queries
// slower, never incomplete: when most have moved, build a new hierarchy outside the step. Frame, units: those of the bounds. Pre: bounds
// lie within WideBvh::kFarthest of zero. Threads: const calls from any number, none during refit. RT: queries, refit yes; the rest set-up.
class ObjectHierarchy {
 public:
  ObjectHierarchy() = default;
  explicit ObjectHierarchy(std::span<const Box> bounds);

  std::size_t object_count() const { return bounds_.size(); }
  const Box& bounds(std::uint32_t object) const { return bounds_[object]; }
  std::size_t bytes() const;

  // Gives the object new bounds. Work: one node per level of the tree.
  void refit(std::uint32_t object, const Box& bounds) noexcept;

  // Calls visit(object) for every object whose bounds overlap the query. A visit that returns false ends the search.
  template <class Visit>
  void for_each_overlapping(const Box& query, Visit&& visit) const;

  // Calls bound_squared = visit(object, bound_squared) for every object whose bounds lie nearer to p than sqrt(bound_squared), in roughly
  // increasing distance. A visit never returns a larger bound than it was given.
  template <class Visit>
  void visit_nearest(const Vec3& p, double bound_squared, Visit&& visit) const;

  // The same, one object at a time (WideBvh::NearestSearch). It also returns some objects that only nearly lie within the bound.
  std::optional<std::uint32_t> next_nearest(WideBvh::NearestSearch& search, double bound_squared) const noexcept {
    return search.next(tree_, bound_squared);
  }

  // Calls until = visit(object, until) for every object whose bounds come within `radius` of the segment from p to p + motion before the
  // time `until` (0 at p, 1 at p + motion), roughly in order; also for some that nearly do. A result below 0 ends the search.
  template <class Visit>
  void visit_along(const Vec3& p, const Vec3& motion, double radius, double until, Visit&& visit) const {
    tree_.visit_along(p, motion, radius, until, std::forward<Visit>(visit));
  }

 private:
  std::vector<Box> bounds_;
  WideBvh tree_{std::span<const Box>()};
  WideBvh::Parents parents_;
};

// ---------------------------------------------------------------------------------------------------------------------

template <class Visit>
void ObjectHierarchy::for_each_overlapping(const Box& query, Visit&& visit) const {
  tree_.for_each_overlapping(query, [&](std::uint32_t object) {
    if (!bounds_[object].overlaps(query)) return true;  // the tree's boxes are rounded outward
    if constexpr (std::is_same_v<decltype(visit(object)), bool>) return visit(object);
    visit(object);
    return true;
  });
}

template <class Visit>
void ObjectHierarchy::visit_nearest(const Vec3& p, double bound_squared, Visit&& visit) const {
  tree_.visit_nearest(p, bound_squared, [&](std::uint32_t object, double bound) {
    return bounds_[object].distance_squared(p) < bound ? visit(object, bound) : bound;
  });
}

}  // namespace hapton
