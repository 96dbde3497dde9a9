#include <algorithm>
#include <array>
#include <cmath>

#include "core/force/force_method.h"
#include "core/force/moving_method.h"
#include "core/force/proxy/proxy_method.h"
#include "core/force/reference/reference_method.h"
#include "core/force/sculpt/sculpt_method.h"
#include "core/force/smooth/smooth_method.h"
#include "core/force/sweep/sweep_method.h"
#include "core/force/virtual_coupling.h"

namespace hapton {
namespace {

struct Entry {
  std::string_view name;
  Result<std::unique_ptr<ForceMethod>> (*make)(const MethodSettings&, const TouchScene&);
  bool supports_motion = false;       // no surface that moves onto its proxy crosses the proxy
  bool supports_deformation = false;  // DeformingMethod can run it
  bool supports_spheres = false;      // the probe may be a sphere
};

constexpr std::array kMethods = {
    Entry{"proxy", &ProxyMethod::make, true, true, true},
    Entry{"reference", &ReferenceMethod::make, true, false, true},
    Entry{"smooth", &SmoothMethod::make},
    Entry{"sweep", &SweepMethod::make},
};

}  // namespace

std::string method_names() {
  std::string names;
  for (const Entry& entry : kMethods) {
    names += names.empty() ? "" : ", ";
    names += entry.name;
  }
  return names;
}

bool is_method_name(std::string_view name) {
  return std::any_of(kMethods.begin(), kMethods.end(), [name](const Entry& entry) { return entry.name == name; });
}

bool supports_spheres(std::string_view name) {
  return std::any_of(kMethods.begin(), kMethods.end(), [name](const Entry& entry) { return entry.name == name && entry.supports_spheres; });
}

Result<std::unique_ptr<ForceMethod>> make_method(const MethodSettings& settings, const TouchScene& scene) {
  if (scene.objects.empty()) {
    return fail("method {}: the scene has no objects; add one to touch", settings.name);
  }
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (scene.objects[i].mesh == nullptr) {
      return fail("method {}: object {} has no mesh; give it one", settings.name, i);
    }
    if (scene.objects[i].mesh->triangles.empty()) {
      return fail("method {}: object {} has no triangles; give it a surface to touch", settings.name, i);
    }
  }
  if (!(settings.coupling_n_per_m >= 0.0) || !std::isfinite(settings.coupling_n_per_m)) {
    return fail("method {}: a virtual coupling of {} N/m; give a stiffness above 0, or 0 for none", settings.name,
                settings.coupling_n_per_m);
  }
  for (const Entry& entry : kMethods) {
    if (entry.name != settings.name) continue;
    const TouchScene coupled = couple_scene(scene, settings.coupling_n_per_m);
    if (scene.has_deformation() && !entry.supports_deformation) {
      return fail("method {}: objects of the scene deform, which it does not support; choose proxy", settings.name);
    }
    if (scene.has_motion() && !entry.supports_motion) {
      return fail("method {}: objects of the scene move, which it does not support; choose proxy or reference", settings.name);
    }
    if (scene.has_sculpt()) return SculptMethod::make(entry.make, entry.supports_motion, settings, coupled);
    return scene.has_motion() ? MovingMethod::make(entry.make, settings, coupled) : entry.make(settings, coupled);
  }
  return fail("method '{}' is not known; choose one of: {}", settings.name, method_names());
}

}  // namespace hapton
