#include "scene/scene_combination.h"

#include <algorithm>
#include <string_view>

#include "core/tool/tool_step.h"
#include "scene/text_cursor.h"
#include "scene/tool_obstacles.h"

namespace hapton {
namespace {

// The first object that has the property; null: no object has it.
template <class Is>
const SceneObject* find_object(const Scene& scene, const Is& is) {
  const auto found = std::find_if(scene.objects.begin(), scene.objects.end(), is);
  return found == scene.objects.end() ? nullptr : &*found;
}

std::string_view describe_motion(const SceneObject& object) {
  return object.commanded != nullptr ? "is moved by programs" : "moves by keyframes";
}

std::string_view describe_deformation(const SceneObject& object) {
  return object.program_shape != nullptr ? "is deformed by programs" : "deforms";
}

// For example "FILE: line 3: object 'lid'".
std::string name_at(const std::filesystem::path& path, const SceneObject& object) {
  const std::string line = object.line == 0 ? std::string() : fmt::format("line {}: ", object.line);
  return fmt::format("{}: {}object '{}'", path.string(), line, printable(object.name));
}

// Names the lines as well, because objects may have the same name.
Error make_movable_conflict(const std::filesystem::path& path, const SceneObject& object, std::string_view is, const SceneObject& movable) {
  constexpr std::string_view kFix = "which cannot be combined: keep one of the two";
  if (&object == &movable) return {fmt::format("{} {} and is movable, {}", name_at(path, object), is, kFix)};
  const std::string line = movable.line == 0 ? std::string() : fmt::format(" (line {})", movable.line);
  return {fmt::format("{} {} and '{}'{} is movable, {}", name_at(path, object), is, printable(movable.name), line, kFix)};
}

}  // namespace

Result<void> check_combination(const std::filesystem::path& path, const Scene& scene, bool has_tool) {
  const auto* deforming = find_object(scene, [](const SceneObject& each) { return each.deforms(); });
  const auto* carved = find_object(scene, [](const SceneObject& each) { return each.sculpt.has_value(); });
  std::size_t shaped = 0;
  for (const SceneObject& each : scene.objects) {
    if (each.program_shape != nullptr && ++shaped > ProgramShape::kMaxObjects) {
      return fail("{} exceeds the limit of {} objects that programs deform", name_at(path, each), ProgramShape::kMaxObjects);
    }
  }
  if (has_tool) {
    constexpr std::string_view kNoTool = "which a rigid tool does not support: leave out the tool, or";
    if (deforming != nullptr)
      return fail("{} deforms, {} {}", name_at(path, *deforming), kNoTool,
                  deforming->program_shape != nullptr ? "'deformed_by'" : "the morphs");
    if (carved != nullptr) return fail("{} can be carved, {} 'sculpt'", name_at(path, *carved), kNoTool);
    return {};
  }
  const auto* movable = find_object(scene, [](const SceneObject& each) { return each.is_movable; });
  if (movable == nullptr) return {};
  if (deforming != nullptr) return tl::unexpected(make_movable_conflict(path, *deforming, describe_deformation(*deforming), *movable));
  if (carved != nullptr) return tl::unexpected(make_movable_conflict(path, *carved, "can be carved", *movable));
  const auto* both = find_object(scene, [](const SceneObject& each) { return each.is_movable && each.moves(); });
  if (both != nullptr) return tl::unexpected(make_movable_conflict(path, *both, describe_motion(*both), *both));
  if (const std::size_t parts = make_tool_obstacles(scene.touch_scene()).parts.size(); parts > ToolStep::kMaxParts) {
    return fail(
        "{} is movable, and {} parts of the scene move by themselves: {} at most beside a movable object; let some stand still, or "
        "move together",
        name_at(path, *movable), parts, ToolStep::kMaxParts);
  }
  return {};
}

}  // namespace hapton
