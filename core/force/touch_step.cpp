#include "core/force/touch_step.h"

namespace hapton {
namespace {

// Written coefficient by coefficient without a temporary: the method loads the result at once, and a store of another width would stall
// that load (store forwarding).
MethodInput to_static_scene(const TouchInput& input) {
  MethodInput sample;
  const Vec3 from_origin = input.p_WD - input.X_WS.translation();
  sample.p_SD.noalias() = input.X_WS.linear().transpose().lazyProduct(from_origin);
  sample.dt_s = input.dt_s;
  sample.time_s = input.time_s;
  return sample;
}

}  // namespace

TouchStep::TouchStep(std::shared_ptr<ForceMethod> method, const TouchScene& scene)
    : method_(std::move(method)), has_motion_(scene.has_motion()) {
  if (!scene.has_effects()) return;
  std::vector<SurfaceEffects> surfaces;
  for (const TouchObject& object : scene.objects) {
    surfaces.push_back(object.effects);
    maps_.push_back(object.effects.maps.is_on() ? std::make_unique<MapFinder>(object.effects.maps) : nullptr);
  }
  effects_ = std::make_unique<EffectStep>(std::move(surfaces), scene.effects);
}

TouchOutput TouchStep::step(const TouchInput& input) noexcept {
  const MethodInput sample = to_static_scene(input);
  const MethodOutput result = method_->step(sample);
  // One variable for every return: it is built where the caller wants it, and never copied.
  TouchOutput output;
  output.contact = result.contact;
  output.object = result.object;
  if (result.contact) {
    output.force_n = input.X_WS.linear() * result.force_n;
    output.visual_offset_m = input.X_WS.linear() * (result.p_SP - sample.p_SD);
  }
  if (effects_ != nullptr) [[unlikely]]
    output = add_effects(input, sample, result);
  return output;
}

// Not inlined: its registers and stack would cost every step of a scene without effects.
[[gnu::noinline]] TouchOutput TouchStep::add_effects(const TouchInput& input, const MethodInput& sample,
                                                     const MethodOutput& result) noexcept {
  if (last_.X_WS.matrix() != input.X_WS.matrix())
    effects_->note_scene_moved(to_static_scene({.p_WD = last_.p_WD, .X_WS = input.X_WS}).p_SD);
  last_ = input;
  SurfaceContact contact = {.force_n = result.force_n, .p_SP = result.p_SP, .object = result.object, .contact = result.contact};
  std::optional<MapSample> map;
  if (result.contact && result.object >= 0 && result.object < static_cast<int>(maps_.size())) {
    if (MapFinder* finder = maps_[static_cast<std::size_t>(result.object)].get()) contact.map = &map.emplace(finder->find(result.p_SP));
  }
  const EffectResult felt = effects_->step(sample.p_SD, sample.dt_s, contact, input.buttons);
  TouchOutput output;
  output.contact = felt.is_felt;
  output.object = result.object;
  if (felt.is_felt) output.force_n = input.X_WS.linear() * felt.force_n;
  if (result.contact) output.visual_offset_m = input.X_WS.linear() * (felt.p_SP - sample.p_SD);
  return output;
}

void TouchStep::reset(const TouchInput& input) noexcept {
  method_->reset(to_static_scene(input).p_SD);
  forget_effects(input);
}

void TouchStep::resume(const TouchInput& input) noexcept {
  method_->resume(to_static_scene(input).p_SD);
  forget_effects(input);
}

void TouchStep::forget_effects(const TouchInput& input) noexcept {
  if (effects_ == nullptr) return;
  effects_->reset();
  last_ = input;
}

}  // namespace hapton
