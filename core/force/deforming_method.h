#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>

#include "core/collision/deforming_geometry.h"
#include "core/force/carried_proxy.h"
#include "core/force/force_method.h"

namespace hapton {

// The method `proxy` for one object that deforms (TouchObject::deformation): in each step the mesh takes its shape at the time of the
// sample and carries the probe along (CarriedProxy).
//
// Frame: S. RT: as ForceMethod; while the hand is near the surface, each vertex that moves adds a few ns to a step. Threads: as
// ForceMethod.
class DeformingMethod final : public ForceMethod {
 public:
  // Pre: the scene is one object, which deforms. Error: whatever ProxyMethod rejects; a probe with a radius; shading; a surface that is
  // not walkable at rest (check_shapes tests the other shapes).
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override { return carried_.step(input); }
  void reset(const Vec3& p_SD) noexcept override { carried_.reset(p_SD); }
  void resume(const Vec3& p_SP) noexcept override { carried_.resume(p_SP); }
  std::optional<Vec3> held_at() const noexcept override { return carried_.held_at(); }
  void set_materials(std::span<const Material> materials) noexcept override { carried_.method().set_materials(materials); }
  std::optional<SurfacePlace> find_place(int /*object*/) const noexcept override { return carried_.find_place(); }
  std::string describe() const override;

 private:
  DeformingMethod(std::unique_ptr<ForceMethod> method, const TouchObject& object)
      : carried_(std::move(method), object.mesh, object.deformation) {}

  CarriedProxy<DeformingGeometry> carried_;
};

// A ProxyMethod for one object that deforms. all_shapes: box in frame S that holds its vertices at all times. Error: as
// DeformingMethod::make. RT: set-up only.
Result<std::unique_ptr<ForceMethod>> make_proxy_of_deforming(const MethodSettings& settings, const TouchScene& scene,
                                                             const Box& all_shapes);

}  // namespace hapton
