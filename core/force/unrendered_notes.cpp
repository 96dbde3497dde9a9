#include "core/force/unrendered_notes.h"

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

bool has_effects(const TouchObject& object) {
  const Material& material = object.material;
  return object.effects.any() || material.friction_static > 0.0 || material.damping_ns_per_m > 0.0;
}

}  // namespace

std::string note_bare_layer(const TouchScene& scene) {
  return note_objects(scene, has_effects,
                      "their effects, damping and friction begin at the surface, and not in the layer outside of it; choose --layer 0");
}

}  // namespace hapton
