#include "core/effects/effect_step.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

struct ForceOf {
  const EffectSample& sample;
  BurstEffect::State& burst;
  MassEffect::State& mass;

  Vec3 operator()(const BurstEffect& effect) const noexcept { return effect.force(sample, burst); }
  Vec3 operator()(const MassEffect& effect) const noexcept { return effect.force(sample, mass); }
  template <class Effect>
  Vec3 operator()(const Effect& effect) const noexcept {
    return effect.force(sample);
  }
};

// Position of the drawn tip: on the undeformed layer that resists, as the probe is drawn on an undeformed surface.
Vec3 tip_in_layers(const Vec3& p_SD, const Vec3& p_SP, double depth_m, const TissueLayers& layers,
                   const TissueLayers::State& state) noexcept {
  const bool resists = state.punctured < layers.count() && state.rest_m < depth_m;
  return resists ? Vec3(p_SP + (state.rest_m / depth_m) * (p_SD - p_SP)) : p_SD;
}

// U of SurfaceMaps: of the method's spring, and of the progressive part beside it, which no image scales.
double spring_energy(double method_n, double depth_m, double pressed_m) noexcept {
  return 0.5 * method_n / depth_m * pressed_m * pressed_m;
}

Vec3 tangential(const Vec3& v, const Vec3& normal) noexcept { return v - v.dot(normal) * normal; }

}  // namespace

EffectStep::EffectStep(std::vector<SurfaceEffects> surfaces, std::vector<SwitchedEffect> space)
    : surfaces_(std::move(surfaces)), states_(surfaces_.size()) {
  const auto has_texture = [](const SurfaceEffects& surface) { return surface.texture.is_on(); };
  if (std::any_of(surfaces_.begin(), surfaces_.end(), has_texture)) texture_.emplace();
  for (SwitchedEffect& effect : space) space_.push_back({.effect = std::move(effect), .burst = {}, .mass = {}, .on = {}});
}

void EffectStep::reset() noexcept {
  velocity_.reset();
  friction_ = {};
  if (texture_) texture_.emplace();
  time_s_ = 0.0;
  touched_ = -1;
  in_contact_ = false;
  contacts_ = 0;
  for (ObjectState& state : states_) state = {};
  for (Placed& placed : space_) {
    placed.burst = {};
    placed.mass = {};
    placed.on = {};
  }
}

void EffectStep::set_drag(std::size_t object, const SurfaceDrag& drag) noexcept {
  SurfaceEffects& surface = surfaces_[object];
  surface.drag = drag;
  if (surface.layers.is_on()) surface.drag.damping_ns_per_m = 0.0;
}

bool EffectStep::any() const noexcept {
  return !space_.empty() || std::any_of(surfaces_.begin(), surfaces_.end(), [](const SurfaceEffects& surface) { return surface.any(); });
}

EffectResult EffectStep::step(const Vec3& p_SD, double dt_s, const SurfaceContact& contact, std::uint32_t buttons) noexcept {
  if (!p_SD.allFinite()) return {.force_n = Vec3::Zero(), .p_SP = contact.p_SP, .is_felt = false};
  velocity_.add(p_SD, dt_s);
  const double passed_s = dt_s > 0.0 ? std::min(dt_s, kLongestS) : 0.0;
  time_s_ += passed_s;
  const Vec3 before = std::exchange(last_p_SD_, p_SD);
  const EffectSample sample = {.p_SD = p_SD, .v_SD = velocity_.mean(), .time_s = time_s_};

  EffectResult result = {.force_n = contact.force_n, .p_SP = contact.p_SP, .is_felt = false};
  const bool is_known = contact.contact && contact.object >= 0 && contact.object < static_cast<int>(surfaces_.size());
  if (is_known) {
    result.force_n = surface_force(sample, p_SD - before, passed_s, contact, result.p_SP);
  } else {
    result.force_n += leave_surface(sample);
  }
  result.force_n += space_force(sample, buttons);
  if (!result.force_n.allFinite()) result.force_n = contact.force_n;
  if (!result.p_SP.allFinite()) result.p_SP = p_SD;
  result.is_felt = contact.contact || !result.force_n.isZero(0.0);
  return result;
}

Vec3 EffectStep::step_in_space(const Vec3& p_SD, double dt_s, std::uint32_t buttons) noexcept {
  touched_ = -1;
  return step(p_SD, dt_s, {}, buttons).force_n;
}

SurfaceEffectState& EffectStep::state_of(int object) noexcept {
  if (!in_contact_) ++contacts_;
  in_contact_ = true;
  touched_ = object;
  ObjectState& state = states_[static_cast<std::size_t>(object)];
  if (state.contact != contacts_) state = {.effects = {}, .contact = contacts_};
  return state.effects;
}

Vec3 EffectStep::surface_force(const EffectSample& sample, const Vec3& motion, double dt_s, const SurfaceContact& contact,
                               Vec3& p_SP) noexcept {
  const SurfaceEffects& surface = surfaces_[static_cast<std::size_t>(contact.object)];
  const bool begins = !in_contact_;
  SurfaceEffectState& state = state_of(contact.object);
  if (texture_ && (begins || !surface.texture.is_on())) texture_->begin();
  if (!surface.any()) {
    friction_ = {};
    return contact.force_n;
  }

  const Vec3 to_proxy = contact.p_SP - sample.p_SD;
  const double method_n = contact.force_n.norm();
  const Vec3 normal = method_n > 0.0 ? Vec3(contact.force_n / method_n) : Vec3(to_proxy.normalized());
  // Along the normal: the contact point of method sweep lags by centimetres behind a hand that slides.
  const double depth_m = to_proxy.dot(normal);
  if (!(depth_m > 0.0)) return contact.force_n;

  // The depth below the bumps, and the force there along the normal. A method's force grows in proportion to the depth.
  const MapSample map = contact.map != nullptr ? *contact.map : MapSample();
  const double lowered_m = surface.bumps.is_on() ? surface.bumps.height_at(contact.p_SP) : map.height_m;
  const double pressed_m = std::max(0.0, depth_m + lowered_m);
  double pressed_n = map.stiffness * method_n * (pressed_m / depth_m);
  if (surface.progressive.is_on()) pressed_n += surface.progressive.force(pressed_m);
  const Vec3 slope = tangential(surface.bumps.is_on() ? surface.bumps.gradient_at(contact.p_SP) : map.height_gradient, normal);
  if (surface.layers.is_on()) {
    // Drag works against the rate of the pressed depth, so that it takes energy on bumps as well.
    pressed_n = surface.layers.force(pressed_m, -sample.v_SD.dot(normal - slope), state.layers);
    p_SP = tip_in_layers(sample.p_SD, contact.p_SP, depth_m, surface.layers, state.layers);
  }
  if (surface.drag.damping_ns_per_m > 0.0) pressed_n = surface.drag.damped(pressed_n, velocity_.newest().dot(normal));
  Vec3 force_n = pressed_n * (normal - slope);
  if (surface.maps.stiffness.is_on()) force_n -= spring_energy(method_n, depth_m, pressed_m) * tangential(map.stiffness_gradient, normal);
  const bool has_friction_map = surface.maps.friction.is_on();
  if ((has_friction_map || surface.drag.has_friction()) && method_n > 0.0) {
    const auto coefficients = has_friction_map ? MapFriction::Coefficients{map.friction, map.friction} : surface.drag.friction;
    force_n +=
        MapFriction::force(begins ? Vec3(Vec3::Zero()) : motion, normal, method_n / depth_m, std::abs(pressed_n), coefficients, friction_);
  } else {
    friction_ = {};
  }
  if (surface.viscosity.is_on()) force_n += surface.viscosity.force(sample.v_SD, normal, std::abs(pressed_n));
  if (surface.maps.viscosity.is_on()) {
    const SurfaceViscosity there{.damping_ns_per_m = map.viscosity_ns_per_m};
    force_n += there.force(sample.v_SD, normal, std::abs(pressed_n));
  }
  if (surface.texture.is_on()) force_n += texture_->force(surface.texture, sample.v_SD, normal, std::abs(pressed_n), dt_s);
  if (surface.tap.is_on()) {
    if (begins) surface.tap.begin(-velocity_.newest().dot(normal), sample.time_s, state.tap);
    force_n += surface.tap.force(sample.time_s, state.tap) * normal;
  }
  if (surface.snap.is_on()) SurfaceSnap::touch(contact.p_SP, normal, state.snap);
  return force_n;
}

// The end of contact: layers are whole again and vibrations end; a surface that snaps still attracts.
Vec3 EffectStep::leave_surface(const EffectSample& sample) noexcept {
  in_contact_ = false;
  friction_ = {};
  if (touched_ < 0) return Vec3::Zero();
  const auto object = static_cast<std::size_t>(touched_);
  return surfaces_[object].snap.force(sample, states_[object].effects.snap);
}

Vec3 EffectStep::space_force(const EffectSample& sample, std::uint32_t buttons) noexcept {
  Vec3 sum = Vec3::Zero();
  for (auto& [effect, burst, mass, on] : space_) {
    const bool is_pressed = effect.on.update(buttons, sample.time_s, on);
    if (effect.on.button == 0) {
      sum += std::visit(ForceOf{sample, burst, mass}, effect.effect);
    } else if (const auto* started = std::get_if<BurstEffect>(&effect.effect)) {
      sum += started->force_on_press(sample, is_pressed, burst);
    } else if (const auto* towed = std::get_if<MassEffect>(&effect.effect)) {
      sum += on.gain * towed->force(sample, mass);  // follows the hand while the button is up, so that a press begins without a jolt
    } else if (on.gain > 0.0) {
      EffectSample since_press = sample;
      since_press.time_s -= on.began_s;
      sum += on.gain * std::visit(ForceOf{since_press, burst, mass}, effect.effect);
    }
  }
  return sum;
}

}  // namespace hapton
