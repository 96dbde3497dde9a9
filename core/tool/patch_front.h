#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/triangle_distance.h"
#include "core/tool/patch_tree.h"
#include "core/tool/swept_motion.h"

namespace hapton {

// Walks the trees of tool and scene together over a motion of the tool, and finds the triangles that may come within a distance of each
// other. Two boxes are apart if one of their six axes, held fixed over the motion, separates their paths: a motion along a surface does not
// bring boxes together that face each other across the gap.
//
// The pairs of boxes where a walk has ended are kept, each with a lower bound of its distance (front tracking, Li & Chen 1998). The next
// walk begins there, and tests again only what the tool's motion since then, and over the walk's own motion, could bring together.
// Work: at most kMostTests pairs of boxes a walk. RT: for_each_near yes, construction set-up only. Pre: the trees outlive this.
class PatchFront {
 public:
  static constexpr std::size_t kMostTests = 1U << 20;

  // radius: the largest distance of a point of the tool from the grip point.
  PatchFront(const PatchTree& tool, const PatchTree& scene, double radius);

  // What a visitor found of a pair of triangles.
  struct Visited {
    double gap;    // how far apart at least the two are at the start of the motion, as far as the visitor is interested in them
    double rest;   // the same without what it knows already
    bool goes_on;  // false ends the walk
  };
  // The visitors of the next walks know nothing.
  void forget() noexcept { ++epoch_; }
  // Calls visit(tool_triangle, scene_triangle) for all pairs that come within `distance` over the motion, and for some that nearly do, but
  // for those where what is left to know is farther. The next walks visit a pair again when it may have come near. False if the walk was
  // ended, or was longer than kMostTests; pairs are then left out.
  template <class Visit>
  bool for_each_near(const SweptMotion& motion, double distance, Visit&& visit) noexcept;

 private:
  struct Pair {
    std::uint32_t tool;  // nodes
    std::uint32_t scene;
  };
  struct ToolBox {
    void place(const PatchTree::Node& tool, const SweptMotion& motion);

    std::uint64_t walk = 0;  // that it was made for
    std::uint32_t node = 0;
    Vec3 centre;  // scene frame
    Vec3 half;
    Vec3 displacement;  // of the centre
    Mat3 axes;          // columns
    Lanes4 lanes[3];    // of the axes, by coordinate
    Lanes4 half_lanes;
    Lanes4 displacement_lanes;  // along the axes
    double slack = 0.0;         // what the box's paths may differ by from that of its centre
    double still_slack = 0.0;   // without the motion
  };
  struct Apart {
    double distance;  // lower bound at the start of the motion
    bool over_motion;
  };

  static Apart test(const ToolBox& tool, const PatchTree::Node& scene, double clearance) noexcept;
  const ToolBox& placed(std::uint32_t node, const SweptMotion& motion) noexcept;
  // Prepares a walk; returns the distance above which a pair of boxes needs no test.
  float begin(const SweptMotion& motion, double distance) noexcept;
  // Keeps a pair where the walk has ended, in place of the one that it came from, or as a new one. False if there is no room.
  bool keep(Pair pair, double distance, double rest) noexcept;
  // Walks from a pair down. False if the walk has to end.
  template <class Visit>
  bool descend(Pair from, const SweptMotion& motion, double distance, Visit&& visit) noexcept;

  static constexpr std::size_t kMostEnded = 1U << 17;
  static constexpr std::size_t kNone = ~std::size_t{0};
  static constexpr std::size_t kBoxes = 512;

  const PatchTree* tool_;
  const PatchTree* scene_;
  double radius_;
  std::vector<Pair> ended_;
  std::vector<float> until_;               // by pair: lower bound of its distance, plus what the tool had travelled then
  std::vector<float> rest_until_;          // the same without what visitors know, of pairs that they have visited
  std::vector<std::uint64_t> visited_in_;  // epoch in which rest_until_ was found
  std::uint64_t epoch_ = 1;                // counts up when visitors forget
  std::size_t count_ = 0;
  std::size_t free_ = kNone;     // index of the pair that is replaced
  std::size_t first_count_ = 0;  // of the walk from the roots
  std::size_t tests_ = 0;
  Placement at_;
  double travelled_ = 0.0;      // since the walk from the roots
  std::vector<ToolBox> boxes_;  // by the last bits of the node's number
  std::uint64_t walk_ = 0;
};

// ---------------------------------------------------------------------------------------------------------------------

template <class Visit>
bool PatchFront::for_each_near(const SweptMotion& motion, double distance, Visit&& visit) noexcept {
  if (tool_->nodes().empty() || scene_->nodes().empty()) return true;
  const float enough = begin(motion, distance);
  bool goes_on = true;
  const std::size_t before = count_;
  for (std::size_t i = 0; i < before && goes_on; ++i) {
    if (until_[i] > enough || (visited_in_[i] == epoch_ && rest_until_[i] > enough)) continue;
    free_ = i;
    goes_on = descend(ended_[i], motion, distance, visit);
  }
  if (!goes_on) count_ = 0;
  if (first_count_ == 0) first_count_ = count_;
  return goes_on;
}

template <class Visit>
bool PatchFront::descend(Pair from, const SweptMotion& motion, double distance, Visit&& visit) noexcept {
  std::array<Pair, 2 * PatchTree::kMostDepth + 2> stack;
  int top = 0;
  stack[top++] = from;
  while (top > 0) {
    const Pair pair = stack[--top];
    if (++tests_ > kMostTests) return false;
    const PatchTree::Node& tool = tool_->nodes()[pair.tool];
    const PatchTree::Node& scene = scene_->nodes()[pair.scene];
    const Apart apart = test(placed(pair.tool, motion), scene, distance);
    if (apart.over_motion || (tool.is_leaf() && scene.is_leaf())) {
      const Visited found = apart.over_motion ? Visited{0.0, 0.0, true} : visit(tool_->triangle(tool), scene_->triangle(scene));
      if (!found.goes_on || !keep(pair, std::max(apart.distance, found.gap), std::max(apart.distance, found.rest))) return false;
      continue;
    }
    const bool splits_tool = !tool.is_leaf() && (scene.is_leaf() || tool.half[2] > scene.half[2]);
    if (splits_tool) {
      stack[top++] = {tool.link + 1, pair.scene};
      stack[top++] = {tool.link, pair.scene};
    } else {
      stack[top++] = {pair.tool, scene.link + 1};
      stack[top++] = {pair.tool, scene.link};
    }
  }
  return true;
}

}  // namespace hapton
