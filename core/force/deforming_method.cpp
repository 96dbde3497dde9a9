#include "core/force/deforming_method.h"

#include <fmt/core.h>

namespace hapton {

Result<std::unique_ptr<ForceMethod>> make_proxy_of_deforming(const MethodSettings& settings, const TouchScene& scene,
                                                             const Box& all_shapes) {
  if (settings.probe_radius_m > 0.0) return fail("proxy: an object deforms, which needs a point probe: leave out the probe radius");
  if (settings.shading > 0.0) return fail("proxy: an object deforms, which cannot be combined with shading: leave it out");
  TouchScene alone = scene;
  alone.part_of = all_shapes;
  auto method = ProxyMethod::make(settings, alone);
  if (!method) return method;
  const auto& geometry = static_cast<const ProxyMethod&>(**method).geometry();
  if (!geometry.object_geometry(0).is_walkable()) {
    return fail("proxy: an object deforms whose surface touches or comes near itself, or has an edge of three triangles: repair it");
  }
  return method;
}

Result<std::unique_ptr<ForceMethod>> DeformingMethod::make(const MethodSettings& settings, const TouchScene& scene) {
  const TouchObject& object = scene.objects.front();
  auto method = make_proxy_of_deforming(settings, scene, bounds_of_all_shapes(*object.mesh, *object.deformation));
  if (!method) return method;
  return std::unique_ptr<ForceMethod>(new DeformingMethod(std::move(*method), object));
}

std::string DeformingMethod::describe() const {
  const DeformingGeometry& surface = carried_.surface();
  return fmt::format("deforms for {:g} s{}: {} vertices move, {} trees of {:.3g} MB\n", surface.deformation().duration_s(),
                     surface.deformation().loops() ? ", repeated" : "", surface.deformation().moved().size(), surface.tree_count(),
                     static_cast<double>(surface.bytes()) * 1e-6) +
         carried_.method().describe();
}

}  // namespace hapton
