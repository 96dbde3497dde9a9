#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/collision/touch_geometry.h"
#include "core/tool/placement.h"

namespace hapton {

// A triangle of the tool and one of the scene.
struct TrianglePairIds {
  std::uint32_t tool;
  std::uint32_t scene;  // TouchGeometry's number
};

// The pairs of triangles of tool and scene whose boxes come near each other.
//
// The tool's triangles are in tree order, eight consecutive ones form a cluster, and clusters are the leaves of an implicit binary tree of
// boxes along the tool's axes. A box that is turned into the scene is looked up in the scene's trees; where nothing is near, what lies
// under it is skipped. Frame and units: TouchGeometry's local ones. RT: collect yes, construction set-up only. Pre: both geometries outlive
// this; the scene is built at once.
class NearPairs {
 public:
  NearPairs(const ObjectGeometry& tool, const TouchGeometry& scene, std::size_t most_pairs);

  // Finds all pairs that come within `margin` along each axis, and some that nearly do. False if there are more than most_pairs; the pairs
  // are then incomplete.
  bool collect(const Placement& placement, double margin) noexcept;
  // Ordered by the tool's triangle.
  std::span<const TrianglePairIds> pairs() const { return {pairs_.data(), count_}; }
  // True if the triangles of one of these pairs intersect at a placement (exact signs).
  bool any_intersect(const Placement& placement) const noexcept;

 private:
  static constexpr std::uint32_t kClusterSize = 8;

  Box turned(const Box& box, const Placement& placement, const Mat3& turn, double margin) const noexcept;
  bool collect_cluster(std::uint32_t cluster, const Box& box, const Placement& placement, double margin) noexcept;

  const ObjectGeometry* tool_;
  const TouchGeometry* scene_;
  std::uint32_t cluster_count_ = 0;
  std::uint32_t first_leaf_ = 1;  // of the implicit tree: node n has children 2 n and 2 n + 1, cluster c is node first_leaf_ + c
  std::vector<Box> nodes_;        // tool axes; empty past the last cluster
  std::vector<TrianglePairIds> pairs_;
  std::size_t count_ = 0;
};

}  // namespace hapton
