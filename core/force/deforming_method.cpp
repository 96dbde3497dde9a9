#include "core/force/deforming_method.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

constexpr double kLookSteps = 64.0;  // a search covers what hand and surface can reach in this many steps

}  // namespace

Result<std::unique_ptr<ForceMethod>> DeformingMethod::make(const MethodSettings& settings, const TouchScene& scene) {
  const TouchObject& object = scene.objects.front();
  if (settings.probe_radius_m > 0.0) return fail("proxy: an object deforms, which needs a point probe: leave out the probe radius");
  if (settings.shading > 0.0) return fail("proxy: an object deforms, which cannot be combined with shading: leave it out");
  TouchScene alone = scene;
  alone.part_of = bounds_of_all_shapes(*object.mesh, *object.deformation);
  auto method = ProxyMethod::make(settings, alone);
  if (!method) return tl::unexpected(method.error());
  const auto& geometry = static_cast<const ProxyMethod&>(**method).geometry();
  if (!geometry.object_geometry(0).is_walkable()) {
    return fail("proxy: an object deforms whose surface touches or comes near itself, or has an edge of three triangles: repair it");
  }
  return std::unique_ptr<ForceMethod>(new DeformingMethod(std::move(*method), object));
}

DeformingMethod::DeformingMethod(std::unique_ptr<ForceMethod> method, const TouchObject& object)
    : method_(std::move(method)),
      proxy_(static_cast<ProxyMethod&>(*method_)),
      surface_(proxy_.deforming_geometry(), object.mesh, object.deformation) {}

MethodOutput DeformingMethod::step(const MethodInput& input) noexcept {
  if (!input.p_SD.allFinite() || !std::isfinite(input.time_s)) return {.force_n = Vec3::Zero(), .p_SP = input.p_SD};
  if (!has_begun_ || start_) begin(input);
  const MeshDeformation::Weights weights = surface_.deformation().weights_at(input.time_s);
  double reach_m = surface_.deformation().most_displacement(weights_, weights);
  MethodOutput output{.force_n = Vec3::Zero(), .p_SP = input.p_SD};
  if ((input.p_SD - clear_from_).norm() + reach_m < clear_m_) {
    last_p_SD_ = input.p_SD;
    last_time_s_ = input.time_s;
    return output;
  }
  if (clear_m_ > 0.0) {
    come_near();
    reach_m = surface_.deformation().most_displacement(weights_, weights);
  }
  if (reach_m > 0.0) deform(input, weights, reach_m);
  output = method_->step({.p_SD = input.p_SD, .dt_s = input.dt_s});
  if (!output.contact) look_round(input.p_SD, (input.p_SD - last_p_SD_).norm() + reach_m);
  last_p_SD_ = input.p_SD;
  last_time_s_ = input.time_s;
  return output;
}

// Where hand and surface were in the last step: they had not met.
void DeformingMethod::come_near() noexcept {
  clear_m_ = 0.0;
  to_travel_m_ = 0.0;
  surface_.shape(last_time_s_);
  weights_ = surface_.deformation().weights_at(last_time_s_);
  method_->resume(last_p_SD_);
}

void DeformingMethod::begin(const MethodInput& input) noexcept {
  weights_ = surface_.deformation().weights_at(input.time_s);
  surface_.shape(input.time_s);
  method_->reset(start_.value_or(input.p_SD));
  last_p_SD_ = start_.value_or(input.p_SD);
  start_.reset();
  has_begun_ = true;
  clear_m_ = 0.0;
  to_travel_m_ = 0.0;
}

void DeformingMethod::deform(const MethodInput& input, const MeshDeformation::Weights& weights, double reach_m) noexcept {
  const ProxyMethod::Anchor anchor = proxy_.anchor(reach_m);
  surface_.shape(input.time_s);
  weights_ = weights;
  proxy_.ride(anchor);
}

// Pre: the probe is free, at the device.
void DeformingMethod::look_round(const Vec3& p_SD, double moved_m) noexcept {
  to_travel_m_ -= moved_m;
  if (to_travel_m_ > 0.0) return;
  const double reach_m = kLookSteps * moved_m;
  const double unit_m = proxy_.geometry().unit_m();
  // Less the rounding of the conversion to local units.
  const double clear_m = proxy_.anchor(reach_m).distance * unit_m * (1.0 - 0x1p-40) - 0x1p-48 * (unit_m + p_SD.norm());
  to_travel_m_ = 0.25 * clear_m;
  if (clear_m < 4.0 * moved_m || !(clear_m > 0.0)) return;
  clear_from_ = p_SD;
  clear_m_ = clear_m;
}

std::string DeformingMethod::describe() const {
  return fmt::format("deforms for {:g} s{}: {} vertices move, {} trees of {:.3g} MB\n", surface_.deformation().duration_s(),
                     surface_.deformation().loops() ? ", again and again" : "", surface_.deformation().moved().size(),
                     surface_.tree_count(), static_cast<double>(surface_.bytes()) * 1e-6) +
         method_->describe();
}

}  // namespace hapton
