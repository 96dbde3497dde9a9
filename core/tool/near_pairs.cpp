#include "core/tool/near_pairs.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/collision/triangle_pair.h"

namespace hapton {

NearPairs::NearPairs(const ObjectGeometry& tool, const TouchGeometry& scene, std::size_t most_pairs) : tool_(&tool), scene_(&scene) {
  cluster_count_ = (tool.triangle_count() + kClusterSize - 1) / kClusterSize;
  first_leaf_ = std::bit_ceil(std::max(cluster_count_, 1U));
  nodes_.resize(2 * std::size_t{first_leaf_});
  for (std::uint32_t t = 0; t < tool.triangle_count(); ++t) {
    for (int k = 0; k < 3; ++k) nodes_[first_leaf_ + t / kClusterSize].grow(tool.corner(t, k));
  }
  for (std::uint32_t n = first_leaf_ - 1; n > 0; --n) {
    nodes_[n] = nodes_[2 * n];
    nodes_[n].grow(nodes_[2 * n + 1]);
  }
  pairs_.resize(most_pairs);
}

Box NearPairs::transformed(const Box& box, const Placement& placement, const Mat3& turn, double margin) const noexcept {
  const Vec3 centre = placement.position + turn * box.centre();
  const Vec3 half = turn.cwiseAbs() * (0.5 * (box.high - box.low));
  const double rounding = 0x1p-46 * (centre.cwiseAbs().maxCoeff() + half.maxCoeff());
  const Vec3 reach = half.array() + (margin + rounding);
  return {centre - reach, centre + reach};
}

bool NearPairs::collect_cluster(std::uint32_t cluster, const Box& box, const Placement& placement, double margin) noexcept {
  const std::uint32_t begin = cluster * kClusterSize;
  const std::uint32_t end = std::min(begin + kClusterSize, tool_->triangle_count());
  std::array<Box, kClusterSize> around;
  for (std::uint32_t t = begin; t < end; ++t) {
    for (int k = 0; k < 3; ++k) around[t - begin].grow(placement.at(tool_->corner(t, k)));
    around[t - begin] = around[t - begin].inflated(margin);
  }
  bool fits = true;
  const std::size_t first = count_;
  scene_->for_each_overlapping(box, [&](std::uint32_t id) {
    const ObjectGeometry::Corners c = scene_->corners(id);
    const Box other = Box::around(c.a, c.b, c.c);
    for (std::uint32_t t = begin; t < end && fits; ++t) {
      if (!around[t - begin].overlaps(other)) continue;
      if (count_ == pairs_.size()) fits = false;
      if (fits) pairs_[count_++] = {t, id};
    }
    return fits;
  });
  std::sort(pairs_.begin() + static_cast<std::ptrdiff_t>(first), pairs_.begin() + static_cast<std::ptrdiff_t>(count_),
            [](const TrianglePairIds& a, const TrianglePairIds& b) { return a.tool != b.tool ? a.tool < b.tool : a.scene < b.scene; });
  return fits;
}

bool NearPairs::any_intersect(const Placement& placement) const noexcept {
  return std::any_of(pairs().begin(), pairs().end(), [&](const TrianglePairIds& ids) {
    const ObjectGeometry::Corners a = tool_->corners(ids.tool);
    const ObjectGeometry::Corners b = scene_->corners(ids.scene);
    return intersect_triangles({{placement.at(a.a), placement.at(a.b), placement.at(a.c)}, {b.a, b.b, b.c}}).meets;
  });
}

bool NearPairs::collect(const Placement& placement, double margin) noexcept {
  count_ = 0;
  const Mat3 turn = placement.orientation.toRotationMatrix();
  std::array<std::uint32_t, 64> stack;
  int top = 0;
  stack[top++] = 1;
  while (top > 0) {
    const std::uint32_t node = stack[--top];
    if (nodes_[node].is_empty()) continue;
    const Box box = transformed(nodes_[node], placement, turn, margin);
    if (node >= first_leaf_) {
      if (!collect_cluster(node - first_leaf_, box, placement, margin)) return false;
      continue;
    }
    bool is_near = false;
    scene_->for_each_overlapping(box, [&](std::uint32_t) {
      is_near = true;
      return false;
    });
    if (!is_near) continue;
    stack[top++] = 2 * node + 1;
    stack[top++] = 2 * node;
  }
  return true;
}

}  // namespace hapton
