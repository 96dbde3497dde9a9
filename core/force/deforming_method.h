#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "core/collision/deforming_geometry.h"
#include "core/force/force_method.h"
#include "core/force/proxy/proxy_method.h"

namespace hapton {

// The method `proxy` for one object that deforms (TouchObject::deformation): in each step the mesh has its shape at the time of the sample.
//
// Before each step the surface takes its shape of that time (DeformingGeometry) and carries the probe along: a probe that it holds, or that
// it may have passed, moves to the same place of the deformed surface, on the same side (ProxyMethod::Anchor), and the device point of the
// last sample moves by the same vector. From there the proxy follows the device as usual. So a surface that moves into the hand pushes the
// proxy ahead, friction and damping are relative to the surface, and the proxy never passes it, however far it moved since the last step.
//
// While hand and surface cannot have met since the last search, a step is a few comparisons.
//
// Frame: S. RT: step and reset yes: linear in the vertices that move, a few ns each, where the hand is near. Threads: as ForceMethod.
class DeformingMethod final : public ForceMethod {
 public:
  // Pre: the scene is one object, which deforms. Error: what ProxyMethod rejects; a probe with a radius, shading; a surface that is not
  // walkable at rest (check_shapes tells of the other shapes).
  static Result<std::unique_ptr<ForceMethod>> make(const MethodSettings& settings, const TouchScene& scene);

  MethodOutput step(const MethodInput& input) noexcept override;
  void reset(const Vec3& p_SD) noexcept override { start_ = p_SD; }
  void set_materials(std::span<const Material> materials) noexcept override { method_->set_materials(materials); }
  std::string describe() const override;

 private:
  DeformingMethod(std::unique_ptr<ForceMethod> method, const TouchObject& object);

  void begin(const MethodInput& input) noexcept;
  void come_near() noexcept;
  void deform(const MethodInput& input, const MeshDeformation::Weights& weights, double reach_m) noexcept;
  void look_round(const Vec3& p_SD, double moved_m) noexcept;

  std::unique_ptr<ForceMethod> method_;
  ProxyMethod& proxy_;  // *method_
  DeformingGeometry surface_;
  MeshDeformation::Weights weights_ = {};  // of the present shape
  std::optional<Vec3> start_;              // where the next step begins after reset()
  bool has_begun_ = false;
  Vec3 last_p_SD_ = Vec3::Zero();
  double last_time_s_ = 0.0;
  Vec3 clear_from_ = Vec3::Zero();
  double clear_m_ = 0.0;      // radius around clear_from_ without any surface; 0: not known
  double to_travel_m_ = 0.0;  // how far hand and surface may move together until the next search
};

}  // namespace hapton
