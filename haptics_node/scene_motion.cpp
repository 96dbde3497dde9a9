#include "haptics_node/scene_motion.h"

#include <algorithm>

#include "scene/text_cursor.h"

namespace hapton {

Result<void> check_motion(const Scene& scene, bool has_tool) {
  const auto deforming =
      std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& each) { return each.deformation != nullptr; });
  if (has_tool && deforming != scene.objects.end()) {
    return fail("object '{}' deforms, which a rigid tool does not support: leave out the tool, or the morphs", printable(deforming->name));
  }
  const auto moves = [](const SceneObject& object) { return object.moves(); };
  const auto moving = std::find_if(scene.objects.begin(), scene.objects.end(), moves);
  if (moving == scene.objects.end() || has_tool) return {};
  const auto movable = std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& each) { return each.is_movable; });
  if (movable == scene.objects.end()) return {};
  return fail("object '{}' {} and '{}' is movable, which cannot be combined: keep one of the two", printable(moving->name),
              moving->commanded != nullptr ? "is moved by programs"
              : moving->motion != nullptr  ? "moves by keyframes"
                                           : "deforms",
              printable(movable->name));
}

Result<void> check_sculpt(const Scene& scene, bool has_tool) {
  const auto sculpted =
      std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& each) { return each.sculpt.has_value(); });
  if (sculpted == scene.objects.end()) return {};
  if (has_tool) {
    return fail("object '{}' can be carved, which a rigid tool does not support: leave out the tool, or 'sculpt'",
                printable(sculpted->name));
  }
  const auto movable = std::find_if(scene.objects.begin(), scene.objects.end(), [](const SceneObject& each) { return each.is_movable; });
  if (movable == scene.objects.end()) return {};
  return fail("object '{}' can be carved and '{}' is movable, which cannot be combined: keep one of the two", printable(sculpted->name),
              printable(movable->name));
}

}  // namespace hapton
