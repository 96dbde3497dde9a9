#include "core/force/motion_groups.h"

#include <algorithm>

namespace hapton {
namespace {

bool is_same_motion(const KeyframeMotion* a, const KeyframeMotion* b) { return a == b || (a != nullptr && b != nullptr && *a == *b); }

}  // namespace

std::vector<MotionGroup> group_by_motion(const TouchScene& scene) {
  std::vector<MotionGroup> groups;
  int commanded = 0;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const auto& motion = scene.objects[o].motion;
    const bool is_deforming = scene.objects[o].deforms();
    const bool is_alone = is_deforming || scene.objects[o].command_pivot.has_value();
    const auto same = [&](const MotionGroup& group) {
      return !is_alone && !group.is_alone() && is_same_motion(group.motion.get(), motion.get());
    };
    auto found = std::find_if(groups.begin(), groups.end(), same);
    if (found == groups.end()) found = groups.insert(groups.end(), {.motion = motion, .is_deforming = is_deforming});
    if (scene.objects[o].command_pivot) found->commanded = commanded++;
    found->objects.push_back(static_cast<int>(o));
  }
  std::stable_partition(groups.begin(), groups.end(), [](const MotionGroup& group) { return !group.moves(); });
  return groups;
}

}  // namespace hapton
