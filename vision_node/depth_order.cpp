#include "vision_node/depth_order.h"

#include <algorithm>
#include <cstddef>
#include <utility>

namespace hapton {
namespace {

using DistanceAndIndex = std::pair<float, std::uint32_t>;  // squared distance; first index of the triangle, or number of the cluster

// Ties are ordered by number, so that two pictures of the same view are equal.
void sort(std::vector<DistanceAndIndex>& all) {
  std::sort(all.begin(), all.end(), [](const DistanceAndIndex& a, const DistanceAndIndex& b) {
    return a.first != b.first ? a.first > b.first : a.second < b.second;
  });
}

}  // namespace

void sort_far_to_near(std::vector<std::uint32_t>& indices, const std::vector<FlatVertex>& vertices, const Vec3f& p_UE) {
  std::vector<DistanceAndIndex> order;
  order.reserve(indices.size() / 3);
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    const Vec3f sum = vertices[indices[i]].position + vertices[indices[i + 1]].position + vertices[indices[i + 2]].position;
    order.emplace_back((sum / 3.0F - p_UE).squaredNorm(), static_cast<std::uint32_t>(i));
  }
  sort(order);
  std::vector<std::uint32_t> sorted;
  sorted.reserve(indices.size());
  for (const DistanceAndIndex& each : order) sorted.insert(sorted.end(), indices.begin() + each.second, indices.begin() + each.second + 3);
  indices = std::move(sorted);
}

std::vector<std::uint32_t> order_far_to_near(const std::vector<DetailCluster>& clusters, const Vec3f& p_UE) {
  std::vector<DistanceAndIndex> order;
  order.reserve(clusters.size());
  for (std::size_t i = 0; i < clusters.size(); ++i)
    order.emplace_back((clusters[i].centre - p_UE).squaredNorm(), static_cast<std::uint32_t>(i));
  sort(order);
  std::vector<std::uint32_t> numbers;
  numbers.reserve(order.size());
  for (const DistanceAndIndex& each : order) numbers.push_back(each.second);
  return numbers;
}

}  // namespace hapton
