#include "scene/object_names.h"

#include <fmt/core.h>

#include "scene/text_cursor.h"

namespace hapton {

std::vector<ObjectName> object_names(const Scene& scene) {
  std::vector<ObjectName> names;
  for (const SceneObject& object : scene.objects) names.push_back({object.name, object.material_name});
  return names;
}

std::string describe_object(std::span<const ObjectName> names, int object) {
  if (object < 0 || object >= static_cast<int>(names.size())) return {};
  const ObjectName& name = names[static_cast<std::size_t>(object)];
  return name.material.empty() ? printable(name.object) : fmt::format("{} ({})", printable(name.object), printable(name.material));
}

}  // namespace hapton
