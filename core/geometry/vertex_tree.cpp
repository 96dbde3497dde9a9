#include "core/geometry/vertex_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/geometry/segment_slabs.h"

namespace hapton {
namespace {

bool is_nearer(const VertexTree::NearVertex& a, const VertexTree::NearVertex& b) {
  return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.vertex < b.vertex;
}

double squared_distance_to_box(const Eigen::AlignedBox3d& box, const Vec3& p) {
  return (box.min() - p).cwiseMax(p - box.max()).cwiseMax(0.0).squaredNorm();
}

double squared_distance_to_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? std::clamp(along.dot(p - a) / length, 0.0, 1.0) : 0.0;
  return (p - a - share * along).squaredNorm();
}

}  // namespace

VertexTree::VertexTree(std::span<const Vec3> points, std::vector<std::uint32_t> items)
    : points_(points), items_(std::move(items)), test_counts_(items_.size(), 0) {
  std::sort(items_.begin(), items_.end());
  const auto place = [&](std::uint32_t i) -> const Vec3& { return points_[i]; };
  tree_ = MedianTree(items_, kLeafSize, place, place);
}

void VertexTree::find_nearest(const Vec3& p, std::uint32_t except, double radius, std::size_t max_count,
                              std::vector<NearVertex>& found) const {
  found.clear();
  if (max_count == 0) return;
  const auto distance = [&](std::uint32_t number) { return squared_distance_to_box(tree_.nodes()[number].box, p); };
  const auto enter = [&](double away) {
    return away <= radius * radius && (found.size() < max_count || away <= found.front().squared_distance);
  };
  tree_.visit_nearest_first(distance, enter, [&](const MedianTree::Node& leaf) {
    for (std::uint32_t i = leaf.first; i < leaf.last; ++i) {
      const NearVertex here{(points_[items_[i]] - p).squaredNorm(), items_[i]};
      if (here.vertex == except || here.squared_distance > radius * radius) continue;
      if (found.size() == max_count) {
        if (!is_nearer(here, found.front())) continue;
        std::pop_heap(found.begin(), found.end(), is_nearer);
        found.pop_back();
      }
      found.push_back(here);
      std::push_heap(found.begin(), found.end(), is_nearer);
    }
  });
  std::sort_heap(found.begin(), found.end(), is_nearer);
}

void VertexTree::find_near_segment(const Vec3& a, const Vec3& b, double radius, std::vector<NearVertex>& found) {
  found.clear();
  const Vec3 margin = Vec3::Constant(radius);
  const SegmentSlabs segment(a, b);
  const auto enter = [&](const MedianTree::Node& node) {
    return node.open_items != 0 && segment.meets(node.box.min() - margin, node.box.max() + margin);
  };
  tree_.visit_open(enter, [&](std::uint32_t i) {
    if (test_counts_[i] == kMaxSegments) return false;
    const double away = squared_distance_to_segment(a, b, points_[items_[i]]);
    if (away <= radius * radius) found.push_back({away, items_[i]});
    return ++test_counts_[i] == kMaxSegments;
  });
  std::sort(found.begin(), found.end(), [](const NearVertex& one, const NearVertex& other) { return one.vertex < other.vertex; });
}

}  // namespace hapton
