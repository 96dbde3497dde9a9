#include "haptics_node/scene_probe.h"

#include "runtime/log.h"
#include "scene/find_scene.h"
#include "scene/scene_layout.h"

namespace hapton {

Result<void> take_scene_probe(HapticsOptions& options) {
  const auto path = find_scene(options.scene);
  if (path.extension() != ".toml") {
    if (options.probe.empty()) return {};
    return fail("--probe {}: {} is not a scene file, so it has no probes: leave --probe out", options.probe, path.string());
  }
  const auto layout = read_layout(path);
  if (!layout) return {};  // load_scene rejects this file too, and says why
  const auto probe = find_probe(layout->probes, options.probe);
  if (!probe) return fail("--probe: {}: {}", path.string(), probe.error().what);
  if (*probe == nullptr) return {};
  const ProbeSpec& chosen = **probe;
  if (chosen.radius_m && !options.is_radius_given) options.method.probe_radius_m = *chosen.radius_m;
  if (chosen.shading && !options.is_shading_given) options.method.shading = *chosen.shading;
  if (chosen.method && !options.is_method_given) options.method.name = *chosen.method;
  const bool is_choice = options.probe.empty() && layout->probes.size() > 1;
  log_info("{}{}", describe(chosen),
           is_choice ? fmt::format("; the scene has {} probes, --probe NAME chooses", layout->probes.size()) : "");
  return {};
}

}  // namespace hapton
