#include "core/force/left_out.h"

#include <fmt/core.h>

#include <algorithm>

namespace hapton {
namespace {

template <class Is>
std::string note_objects(const TouchScene& scene, const Is& is, std::string_view what) {
  const auto count = std::count_if(scene.objects.begin(), scene.objects.end(), is);
  if (count == 0) return {};
  return fmt::format("note: {} of {} object{}: {}\n", count, scene.objects.size(), scene.objects.size() == 1 ? "" : "s", what);
}

}  // namespace

std::string note_missing_friction(const TouchScene& scene) {
  const auto has_any = [](const TouchObject& object) {
    const Material& m = object.material;
    return m.friction_static > 0.0 || m.friction_dynamic > 0.0 || m.damping_ns_per_m > 0.0;
  };
  return note_objects(scene, has_any,
                      "their damping and friction are ignored, because this method has neither; choose proxy, or give friction by an "
                      "image (friction_map)");
}

std::string note_bare_layer(const TouchScene& scene) {
  return note_objects(
      scene, [](const TouchObject& object) { return object.effects.any(); },
      "their effects begin at the surface, and not in the layer outside of it; choose --layer 0");
}

}  // namespace hapton
