#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include "core/tool/patch_tree.h"
#include "core/tool/placement.h"

namespace hapton {

// A motion of the tool, with what bounds the paths of its points: each is its straight line from start to end, less the sagitta of its arc.
struct SweptMotion {
  Mat3 orientation;  // at the start
  Vec3 position;
  Vec3 shift;
  Mat3 turned;           // what the turn adds to an arm, along the scene's axes
  double angle = 0.0;    // of the turn
  double sagitta = 0.0;  // of an arm of length 1

  explicit SweptMotion(const RigidMotion& motion)
      : orientation(motion.from.orientation.toRotationMatrix()),
        position(motion.from.position),
        shift(motion.shift),
        turned(turn_by(motion.turn).toRotationMatrix() - Mat3::Identity()),
        angle(motion.turn.norm()),
        sagitta(0.125 * angle * angle) {}

  // From start to end, of a point of the tool with an arm along the scene's axes.
  Vec3 displacement(const Vec3& arm) const { return shift + turned * arm; }
};

// Walks two trees together over a motion of the tool, and finds the leaves that may come within `clearance` of each other. Two boxes are
// apart if one of their six axes, held fixed over the motion, separates their paths: a motion along a surface does not bring boxes
// together that face each other across the gap.
class PatchWalk {
 public:
  PatchWalk(const PatchTree& tool, const PatchTree& scene) : tool_(&tool), scene_(&scene) {}

  // Calls visit(tool_leaf, scene_leaf); one that returns false ends the walk. False if it was ended, or had more than most_tests pairs of
  // boxes to test. RT: yes.
  template <class Visit>
  bool for_each_near(const SweptMotion& motion, double clearance, std::size_t most_tests, Visit&& visit) const;

 private:
  struct ToolBox {
    Vec3 centre;        // scene frame
    Mat3 axes;          // columns
    Vec3 half;
    Vec3 displacement;  // of the centre
    double slack;       // what the box's paths may differ by from that of its centre

    ToolBox(const PatchTree::Node& node, const SweptMotion& motion);
  };

  static bool are_apart(const ToolBox& tool, const PatchTree::Node& scene, double clearance);

  const PatchTree* tool_;
  const PatchTree* scene_;
};

// ---------------------------------------------------------------------------------------------------------------------

inline PatchWalk::ToolBox::ToolBox(const PatchTree::Node& node, const SweptMotion& motion) : half(node.half_size()) {
  const Vec3 arm = motion.orientation * node.at();
  for (int i = 0; i < 3; ++i) axes.col(i) = motion.orientation * node.axis(i);
  centre = motion.position + arm;
  displacement = motion.displacement(arm);
  const double radius = half.norm();
  // 2^-18: the axes are orthonormal to 2^-20.
  slack = motion.angle * radius + motion.sagitta * (arm.norm() + radius) + 0x1p-18 * radius + 0x1p-45 * (1.0 + arm.norm());
}

inline bool PatchWalk::are_apart(const ToolBox& tool, const PatchTree::Node& scene, double clearance) {
  Mat3 axes;
  for (int i = 0; i < 3; ++i) axes.col(i) = scene.axis(i);
  const Vec3 half = scene.half_size();
  const Vec3 between = tool.centre - scene.at();
  const Mat3 cosines = axes.transpose() * tool.axes;
  const Mat3 sizes = cosines.cwiseAbs();
  const double reach = (clearance + tool.slack) * (1.0 + 0x1p-20) + 0x1p-18 * half.norm() + 0x1p-45 * between.norm();
  const auto separates = [reach](const Vec3& along, const Vec3& moved, const Vec3& sum) {
    // The centre's distance from the other's, at the end of its motion that is nearer.
    for (int i = 0; i < 3; ++i) {
      const double approach = along[i] < 0.0 ? -moved[i] : moved[i];
      if (std::fabs(along[i]) + std::min(0.0, approach) > sum[i] + reach) return true;
    }
    return false;
  };
  return separates(axes.transpose() * between, axes.transpose() * tool.displacement, half + sizes * tool.half) ||
         separates(tool.axes.transpose() * between, tool.axes.transpose() * tool.displacement, tool.half + sizes.transpose() * half);
}

template <class Visit>
bool PatchWalk::for_each_near(const SweptMotion& motion, double clearance, std::size_t most_tests, Visit&& visit) const {
  if (tool_->nodes().empty() || scene_->nodes().empty()) return true;
  struct Pair {
    std::uint32_t tool;
    std::uint32_t scene;
  };
  std::array<Pair, 2 * PatchTree::kMostDepth + 2> stack;
  int top = 0;
  stack[top++] = {0, 0};
  std::size_t tests = 0;
  while (top > 0) {
    const Pair pair = stack[--top];
    if (++tests > most_tests) return false;
    const PatchTree::Node& tool = tool_->nodes()[pair.tool];
    const PatchTree::Node& scene = scene_->nodes()[pair.scene];
    if (are_apart(ToolBox(tool, motion), scene, clearance)) continue;
    if (tool.is_leaf() && scene.is_leaf()) {
      if (!visit(tool, scene)) return false;
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
