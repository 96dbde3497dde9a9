#include "core/geometry/far_points.h"

#include <algorithm>
#include <functional>
#include <utility>

namespace hapton {

FarPoints::FarPoints(std::vector<Vec3> points) : points_(std::move(points)), tree_(points_, kLeafSize, std::identity{}, std::identity{}) {
  for (const MedianTree::Node& node : tree_.nodes()) boxes_.push_back({node.box.center(), 0.5 * node.box.sizes()});
  if (!boxes_.empty()) extent_ = 2.0 * boxes_.front().half.maxCoeff();
}

double FarPoints::find_farthest(const Vec3& direction, const Vec3& from, double least) {
  double farthest = least;
  const Vec3 absolute_direction = direction.cwiseAbs();
  // The farther a box reaches in the direction, the smaller is this distance, so visit_nearest_first visits it earlier.
  const auto distance = [&](std::uint32_t number) {
    return -(direction.dot(boxes_[number].centre - from) + absolute_direction.dot(boxes_[number].half));
  };
  const auto enter = [&](double away) {
    ++comparisons_;
    return -away > farthest + kRelativeError * extent_;
  };
  tree_.visit_nearest_first(distance, enter, [&](const MedianTree::Node& leaf) {
    comparisons_ += leaf.last - leaf.first;
    for (std::uint32_t i = leaf.first; i < leaf.last; ++i) {
      farthest = std::max(farthest, direction.dot(points_[i] - from));
    }
  });
  return farthest;
}

}  // namespace hapton
