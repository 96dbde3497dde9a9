#include "core/force/virtual_coupling.h"

#include <cmath>

namespace hapton {

Material couple_material(Material material, double coupling_n_per_m) noexcept {
  if (!(coupling_n_per_m > 0.0) || !std::isfinite(coupling_n_per_m)) return material;
  // Without the product of two large stiffnesses, which might overflow.
  const double share = coupling_n_per_m / (material.stiffness_n_per_m + coupling_n_per_m);
  material.stiffness_n_per_m *= share;
  material.damping_ns_per_m *= share * share;
  return material;
}

TouchScene couple_scene(TouchScene scene, double coupling_n_per_m) {
  for (TouchObject& object : scene.objects) object.material = couple_material(object.material, coupling_n_per_m);
  return scene;
}

}  // namespace hapton
