#include "core/geometry/far_points.h"

#include <algorithm>
#include <utility>

namespace hapton {

FarPoints::FarPoints(std::vector<Vec3> points) : points_(std::move(points)) {
  if (points_.empty()) return;
  build(0, static_cast<std::uint32_t>(points_.size()));
  extent_ = 2.0 * nodes_.front().half.maxCoeff();
}

std::uint32_t FarPoints::build(std::uint32_t first, std::uint32_t last) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  Eigen::AlignedBox3d box;
  for (std::uint32_t i = first; i < last; ++i) box.extend(points_[i]);
  nodes_.push_back({.centre = box.center(), .half = 0.5 * box.sizes(), .first = first, .last = last});
  if (last - first <= kLeafSize) return number;
  int axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(points_.begin() + first, points_.begin() + middle, points_.begin() + last,
                   [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
  build(first, middle);
  const std::uint32_t right = build(middle, last);
  nodes_[number].right = right;
  return number;
}

// Of the box, in the direction.
double FarPoints::reach_of(std::uint32_t number, const Query& query) const noexcept {
  const Node& node = nodes_[number];
  return query.direction.dot(node.centre - query.from) + query.direction.cwiseAbs().dot(node.half);
}

double FarPoints::find_farthest(const Vec3& direction, const Vec3& from, double least) {
  Query query{.direction = direction, .from = from, .farthest = least};
  if (!nodes_.empty()) visit(0, reach_of(0, query), query);
  return query.farthest;
}

void FarPoints::visit(std::uint32_t number, double reach, Query& query) {
  ++compared_;
  if (!(reach > query.farthest + kAgree * extent_)) return;
  const Node& node = nodes_[number];
  if (node.right == 0) {
    compared_ += node.last - node.first;
    for (std::uint32_t i = node.first; i < node.last; ++i) {
      query.farthest = std::max(query.farthest, query.direction.dot(points_[i] - query.from));
    }
    return;
  }
  const std::uint32_t children[] = {number + 1, node.right};
  const double reaches[] = {reach_of(children[0], query), reach_of(children[1], query)};
  const std::size_t first = reaches[0] < reaches[1] ? 1 : 0;
  visit(children[first], reaches[first], query);
  visit(children[1 - first], reaches[1 - first], query);
}

}  // namespace hapton
