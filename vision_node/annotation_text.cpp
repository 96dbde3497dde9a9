#include "vision_node/annotation_text.h"

#include <variant>

#include <fmt/format.h>

namespace hapton {

std::string plural(std::size_t count, std::string_view noun) { return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s"); }

std::string describe_marks(const std::vector<Annotation>& entries) {
  std::size_t strokes = 0;
  for (const Annotation& entry : entries) strokes += std::holds_alternative<Stroke>(entry) ? 1 : 0;
  return plural(strokes, "stroke") + ", " + plural(entries.size() - strokes, "measure");
}

std::string describe_entries(const Annotations& annotations) {
  const std::size_t moved = annotations.put_down.size();
  const std::size_t carves = count_carves(annotations.carved);
  return describe_marks(annotations.entries) + (moved > 0 ? ", " + plural(moved, "object") + " put down" : "") +
         (carves > 0 ? ", " + plural(carves, "carve") : "");
}

std::vector<std::string> list_names(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneObject& object : scene.objects) names.push_back(object.name);
  return names;
}

}  // namespace hapton
