#include "haptics_node/scene_motion.h"

#include <algorithm>

#include "scene/text_cursor.h"

namespace hapton {

Result<void> check_motion(const Scene& scene, bool has_tool) {
  const auto moves = [](const SceneObject& object) { return object.motion != nullptr; };
  const auto moving = std::find_if(scene.objects.begin(), scene.objects.end(), moves);
  if (moving == scene.objects.end()) return {};
  if (has_tool) {
    return fail("object '{}' moves by keyframes, which a rigid tool does not feel yet: leave out the tool, or the keyframes",
                printable(moving->name));
  }
  const auto movable = std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& each) { return each.is_movable; });
  if (movable == scene.objects.end()) return {};
  return fail("object '{}' moves by keyframes and '{}' is movable, which do not go together yet: keep one of the two",
              printable(moving->name), printable(movable->name));
}

}  // namespace hapton
