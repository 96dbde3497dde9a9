#include "core/geometry/vertex_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/geometry/segment_slabs.h"

namespace hapton {
namespace {

bool is_nearer(const VertexTree::Found& a, const VertexTree::Found& b) {
  return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.vertex < b.vertex;
}

double squared_distance_to_box(const Vec3& low, const Vec3& high, const Vec3& p) {
  return (low - p).cwiseMax(p - high).cwiseMax(0.0).squaredNorm();
}

double squared_distance_to_segment(const Vec3& a, const Vec3& b, const Vec3& p) {
  const Vec3 along = b - a;
  const double length = along.squaredNorm();
  const double share = length > 0.0 ? std::clamp(along.dot(p - a) / length, 0.0, 1.0) : 0.0;
  return (p - a - share * along).squaredNorm();
}

}  // namespace

VertexTree::VertexTree(std::span<const Vec3> points, std::vector<std::uint32_t> items)
    : points_(points), items_(std::move(items)), tested_(items_.size(), 0) {
  std::sort(items_.begin(), items_.end());
  if (!items_.empty()) build(0, static_cast<std::uint32_t>(items_.size()));
}

std::uint32_t VertexTree::build(std::uint32_t first, std::uint32_t last) {
  const auto number = static_cast<std::uint32_t>(nodes_.size());
  Node node{.low = points_[items_[first]], .high = points_[items_[first]], .first = first, .last = last, .open = last - first};
  for (std::uint32_t i = first; i < last; ++i) {
    node.low = node.low.cwiseMin(points_[items_[i]]);
    node.high = node.high.cwiseMax(points_[items_[i]]);
  }
  nodes_.push_back(node);
  if (last - first <= kLeafSize) return number;
  int axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const std::uint32_t middle = first + (last - first) / 2;
  std::nth_element(items_.begin() + first, items_.begin() + middle, items_.begin() + last, [&](std::uint32_t i, std::uint32_t j) {
    return points_[i][axis] != points_[j][axis] ? points_[i][axis] < points_[j][axis] : i < j;
  });
  build(first, middle);
  const std::uint32_t right = build(middle, last);
  nodes_[number].right = right;
  return number;
}

void VertexTree::find_nearest(const Vec3& p, std::uint32_t except, double radius, std::size_t most, std::vector<Found>& found) const {
  found.clear();
  if (nodes_.empty() || most == 0) return;
  const auto visit = [&](auto&& self, std::uint32_t number) -> void {
    const Node& node = nodes_[number];
    const double away = squared_distance_to_box(node.low, node.high, p);
    if (away > radius * radius || (found.size() == most && away > found.front().squared_distance)) return;
    if (node.right == kNone) {
      for (std::uint32_t i = node.first; i < node.last; ++i) {
        const Found here{(points_[items_[i]] - p).squaredNorm(), items_[i]};
        if (here.vertex == except || here.squared_distance > radius * radius) continue;
        if (found.size() == most) {
          if (!is_nearer(here, found.front())) continue;
          std::pop_heap(found.begin(), found.end(), is_nearer);
          found.pop_back();
        }
        found.push_back(here);
        std::push_heap(found.begin(), found.end(), is_nearer);
      }
      return;
    }
    const std::uint32_t left = number + 1;
    const bool left_first = squared_distance_to_box(nodes_[left].low, nodes_[left].high, p) <=
                            squared_distance_to_box(nodes_[node.right].low, nodes_[node.right].high, p);
    self(self, left_first ? left : node.right);
    self(self, left_first ? node.right : left);
  };
  visit(visit, 0);
  std::sort_heap(found.begin(), found.end(), is_nearer);
}

void VertexTree::find_near_segment(const Vec3& a, const Vec3& b, double radius, std::vector<Found>& found) {
  found.clear();
  if (nodes_.empty()) return;
  const Vec3 margin = Vec3::Constant(radius);
  const SegmentSlabs segment(a, b);
  // Returns how many items have reached their test limit.
  const auto visit = [&](auto&& self, std::uint32_t number) -> std::uint32_t {
    Node& node = nodes_[number];
    if (node.open == 0 || !segment.meets(node.low - margin, node.high + margin)) return 0;
    std::uint32_t spent = 0;
    if (node.right != kNone) {
      spent = self(self, number + 1);
      spent += self(self, node.right);
    } else {
      for (std::uint32_t i = node.first; i < node.last; ++i) {
        if (tested_[i] == kMaxSegments) continue;
        spent += ++tested_[i] == kMaxSegments ? 1 : 0;
        const double away = squared_distance_to_segment(a, b, points_[items_[i]]);
        if (away <= radius * radius) found.push_back({away, items_[i]});
      }
    }
    node.open -= spent;
    return spent;
  };
  visit(visit, 0);
  std::sort(found.begin(), found.end(), [](const Found& one, const Found& other) { return one.vertex < other.vertex; });
}

}  // namespace hapton
