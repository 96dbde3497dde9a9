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
  std::uint32_t scene;  // as TouchGeometry numbers it
};

// The pairs of triangles of tool and scene whose boxes come near each other.
//
// The tool's triangles are in tree order, eight consecutive ones form a cluster, and clusters are the leaves of an implicit binary tree of
// boxes along the tool's axes. The box of a node, transformed to the scene's frame, is looked up in the scene's trees; if nothing is near
// it, the nodes below are skipped. Frame and units: TouchGeometry's local ones. RT: collect and any_intersect yes, construction set-up
// only. Pre: both geometries outlive this; the scene is not built on_approach (BuildPolicy).
class NearPairs {
 public:
  NearPairs(const ObjectGeometry& tool, const TouchGeometry& scene, std::size_t most_pairs);

  // Finds all pairs whose boxes are at most `margin` apart along each of the scene's axes. False if there are more than most_pairs: pairs()
  // is then incomplete.
  bool collect(const Placement& placement, double margin) noexcept;
  // Ordered by the tool's triangle.
  std::span<const TrianglePairIds> pairs() const { return {pairs_.data(), count_}; }
  // True if the triangles of any pair of pairs() intersect at this placement (exact predicates).
  bool any_intersect(const Placement& placement) const noexcept;

 private:
  static constexpr std::uint32_t kClusterSize = 8;

  Box transformed(const Box& box, const Placement& placement, const Mat3& turn, double margin) const noexcept;
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
