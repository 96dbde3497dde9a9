#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/force/common_proxy.h"
#include "core/force/force_method.h"
#include "core/force/scene_parts.h"

namespace hapton {

// The force method of a scene in which objects move by themselves, by commands, or deform: its parts (SceneParts) have one proxy
// (CommonProxy). A surface that moves towards the hand at speed v changes the force by stiffness times v dt in a step.
//
// Frame: S. RT: step, reset and set_materials yes. Threads: as ForceMethod.
class MovingMethod final : public ForceMethod {
 public:
  // Pre: the scene has motion; each method that `make` makes returns a proxy in MethodOutput::p_SP. Error: that of SceneParts::make.
  static Result<std::unique_ptr<ForceMethod>> make(SceneParts::Make make, const MethodSettings& settings, const TouchScene& scene) {
    auto parts = SceneParts::make(make, settings, scene);
    if (!parts) return tl::unexpected(parts.error());
    return std::unique_ptr<ForceMethod>(new MovingMethod(std::move(*parts)));
  }

  MethodOutput step(const MethodInput& input) noexcept override {
    if (!input.p_SD.allFinite() || !std::isfinite(input.time_s)) return {.force_n = Vec3::Zero(), .p_SP = input.p_SD};
    parts_.begin(input);
    return proxy_.step(parts_, parts_.size(), parts_.has_still(), input.p_SD, input.dt_s);
  }
  void reset(const Vec3& p_SD) noexcept override { proxy_.reset(p_SD); }
  void set_materials(std::span<const Material> materials) noexcept override { parts_.set_materials(materials); }
  bool prepare() override { return parts_.prepare(); }
  StreamedMethod* find_streamed(int object) noexcept override { return parts_.find_streamed(object); }
  std::optional<SurfacePlace> find_place(int object) const noexcept override { return parts_.find_place(object); }
  std::vector<int> list_streamed() const override { return parts_.list_streamed(); }
  std::string describe() const override { return parts_.describe(); }

 private:
  explicit MovingMethod(SceneParts parts) : parts_(std::move(parts)), proxy_(parts_.size(), parts_.extent_m()) {}

  SceneParts parts_;
  CommonProxy proxy_;
};

}  // namespace hapton
