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

// Where the tip is drawn: on the undeformed layer that resists, just as the probe is drawn on an undeformed surface.
Vec3 tip_in_layers(const Vec3& p_SD, const Vec3& p_SP, double depth_m, const TissueLayers& layers,
                   const TissueLayers::State& state) noexcept {
  const bool resists = state.punctured_count < layers.count() && state.rest_depth_m < depth_m;
  return resists ? Vec3(p_SP + (state.rest_depth_m / depth_m) * (p_SD - p_SP)) : p_SD;
}

// U of SurfaceMaps: the energy of the method's spring, without that of the progressive part, which no image scales.
double spring_energy(double method_n, double depth_m, double pressed_m) noexcept {
  return 0.5 * method_n / depth_m * pressed_m * pressed_m;
}

Vec3 limited(const Vec3& v, double most) noexcept {
  const double length = v.norm();
  return length > most ? Vec3(most / length * v) : v;
}

Vec3 tangential(const Vec3& v, const Vec3& normal) noexcept { return v - v.dot(normal) * normal; }

}  // namespace

EffectStep::EffectStep(std::vector<SurfaceEffects> surfaces, std::vector<SwitchedEffect> space, std::vector<int> frame_of)
    : surfaces_(std::move(surfaces)), frame_of_(std::move(frame_of)), states_(surfaces_.size()) {
  for (const int frame : frame_of_) frames_.resize(std::max(frames_.size(), static_cast<std::size_t>(frame + 1)));
  const auto has_texture = [](const SurfaceEffects& surface) { return surface.texture.is_on(); };
  if (std::any_of(surfaces_.begin(), surfaces_.end(), has_texture)) texture_.emplace();
  for (SwitchedEffect& effect : space) space_.push_back({.effect = std::move(effect), .burst = {}, .mass = {}, .switch_state = {}});
}

void EffectStep::reset() noexcept {
  velocity_.reset();
  for (SurfaceFrame& frame : frames_) frame.reset();
  state_frame_ = kStill;
  friction_ = {};
  if (texture_) texture_.emplace();
  time_s_ = 0.0;
  touched_object_ = -1;
  is_in_contact_ = false;
  contacts_ = 0;
  for (ObjectState& state : states_) state = {};
  for (EffectWithState& effect : space_) {
    effect.burst = {};
    effect.mass = {};
    effect.switch_state = {};
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
  if (!frames_.empty()) advance_frames(p_SD, dt_s);
  const Vec3 before = std::exchange(last_p_SD_, p_SD);
  const EffectSample sample = {.p_SD = p_SD, .v_SD = velocity_.mean(), .time_s = time_s_};

  EffectResult result = {.force_n = contact.force_n, .p_SP = contact.p_SP, .is_felt = false};
  const bool is_known = contact.contact && contact.object >= 0 && contact.object < static_cast<int>(surfaces_.size());
  if (is_known) {
    const int frame = frame_of(contact.object);
    if (frame != state_frame_) carry_state_into(frame);
    result.force_n = frame == kStill ? surface_force({sample, velocity_.newest(), p_SD - before, passed_s}, contact, result.p_SP)
                                     : moving_force(frames_[static_cast<std::size_t>(frame)], sample, passed_s, contact, result.p_SP);
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
  touched_object_ = -1;
  return step(p_SD, dt_s, {}, buttons).force_n;
}

SurfaceEffectState& EffectStep::state_of(int object) noexcept {
  if (!is_in_contact_) ++contacts_;
  is_in_contact_ = true;
  touched_object_ = object;
  ObjectState& state = states_[static_cast<std::size_t>(object)];
  if (state.contact != contacts_) state = {.effects = {}, .contact = contacts_};
  return state.effects;
}

void EffectStep::continue_hand_motion(const EffectStep& other) noexcept {
  velocity_ = other.velocity_;
  last_p_SD_ = other.last_p_SD_;
  if (frame_of_ != other.frame_of_) return;
  for (std::size_t f = 0; f < frames_.size(); ++f) frames_[f].follow(other.frames_[f]);
}

void EffectStep::note_scene_moved(const Vec3& last_p_SD) noexcept {
  if (!last_p_SD.allFinite()) return;
  velocity_.move_last(last_p_SD);
  last_p_SD_ = last_p_SD;
  for (SurfaceFrame& frame : frames_) frame.move_last(last_p_SD);
}

// Resets the frames that place() has not placed.
void EffectStep::advance_frames(const Vec3& p_SD, double dt_s) noexcept {
  for (std::size_t f = 0; f < frames_.size(); ++f) {
    if (f < X_SF_.size()) {
      frames_[f].advance(X_SF_[f], p_SD, dt_s);
    } else {
      frames_[f].reset();
    }
  }
  X_SF_ = {};
}

// Turns the state that goes on from surface to surface (friction, texture) from the frame of the last surface into this one.
void EffectStep::carry_state_into(int frame) noexcept {
  const auto axes_of = [&](int which) {
    return which == kStill ? Mat3(Mat3::Identity()) : frames_[static_cast<std::size_t>(which)].axes();
  };
  const Mat3 turn = axes_of(frame).transpose() * axes_of(state_frame_);
  state_frame_ = frame;
  friction_.extension = turn * friction_.extension;
  if (texture_) texture_->turn(turn);
}

Vec3 EffectStep::moving_force(SurfaceFrame& frame, const EffectSample& sample, double dt_s, const SurfaceContact& contact,
                              Vec3& p_SP) noexcept {
  if (contact.place != nullptr) frame.follow_deformation(contact.place->moved, dt_s);
  SurfaceContact contact_in_frame = contact;
  contact_in_frame.force_n = frame.axes().transpose() * contact.force_n;
  contact_in_frame.p_SP = frame.to_frame(contact.p_SP);
  const SurfaceSample surface_sample = {.sample = {.p_SD = frame.p_FD(), .v_SD = frame.velocity().mean(), .time_s = sample.time_s},
                                        .newest_v = frame.velocity().newest(),
                                        .motion = frame.motion(),
                                        .dt_s = dt_s};
  Vec3 p_FP = contact_in_frame.p_SP;
  const Vec3 force_F = surface_force(surface_sample, contact_in_frame, p_FP);
  if (p_FP != contact_in_frame.p_SP) p_SP = frame.to_scene(p_FP);
  return frame.axes() * force_F;
}

Vec3 EffectStep::surface_force(const SurfaceSample& surface_sample, const SurfaceContact& contact, Vec3& p_SP) noexcept {
  const EffectSample& sample = surface_sample.sample;
  const SurfaceEffects& surface = surfaces_[static_cast<std::size_t>(contact.object)];
  const bool begins = !is_in_contact_;
  SurfaceEffectState& state = state_of(contact.object);
  if (texture_ && (begins || !surface.texture.is_on())) texture_->begin();
  if (!surface.any()) {
    friction_ = {};
    return contact.force_n;
  }

  const Vec3 to_proxy = contact.p_SP - sample.p_SD;
  const double method_n = contact.force_n.norm();
  const Vec3 normal = method_n > 0.0 ? Vec3(contact.force_n / method_n) : Vec3(to_proxy.normalized());
  // Only the part along the normal counts: with method sweep, the contact point lags centimetres behind a hand that slides.
  const double depth_m = to_proxy.dot(normal);
  if (!(depth_m > 0.0)) {
    is_in_contact_ = !begins;  // a contact begins only with the first depth above zero
    return contact.force_n;
  }

  // The depth below the bumps, and the force there along the normal. A method's force grows in proportion to the depth.
  const MapSample map = contact.map != nullptr ? *contact.map : MapSample();
  const Vec3& p_SB = contact.place != nullptr ? contact.place->p_rest : contact.p_SP;  // where the bumps are evaluated
  const double lowered_m = surface.bumps.is_on() ? surface.bumps.height_at(p_SB) : map.height_m;
  const double pressed_m = std::max(0.0, depth_m + lowered_m);
  double pressed_n = map.stiffness * method_n * (pressed_m / depth_m);
  if (surface.progressive.is_on()) pressed_n += surface.progressive.force(pressed_m);
  const auto along = [&](const Vec3& gradient) {
    return tangential(contact.place != nullptr ? Vec3(contact.place->gradient * gradient) : gradient, normal);
  };
  Vec3 slope = along(surface.bumps.is_on() ? surface.bumps.gradient_at(p_SB) : map.height_gradient);
  if (contact.place != nullptr) slope = limited(slope, SurfaceMaps::kSteepest);  // a triangle that is compressed makes bumps steeper
  if (surface.layers.is_on()) {
    // Drag works against the rate of the pressed depth, so that it takes energy on bumps as well.
    pressed_n = surface.layers.force(pressed_m, -sample.v_SD.dot(normal - slope), state.layers);
    p_SP = tip_in_layers(sample.p_SD, contact.p_SP, depth_m, surface.layers, state.layers);
  }
  if (surface.drag.damping_ns_per_m > 0.0) pressed_n = surface.drag.damped(pressed_n, surface_sample.newest_v.dot(normal));
  Vec3 force_n = pressed_n * (normal - slope);
  if (surface.maps.stiffness.is_on()) force_n -= spring_energy(method_n, depth_m, pressed_m) * along(map.stiffness_gradient);
  add_friction(surface_sample, surface, map,
               {.normal = normal, .method_n = method_n, .depth_m = depth_m, .normal_n = pressed_n, .begins = begins}, force_n);
  if (surface.viscosity.is_on()) force_n += surface.viscosity.force(sample.v_SD, normal, std::abs(pressed_n));
  if (surface.maps.viscosity.is_on()) {
    const SurfaceViscosity there{.damping_ns_per_m = map.viscosity_ns_per_m};
    force_n += there.force(sample.v_SD, normal, std::abs(pressed_n));
  }
  if (surface.texture.is_on()) force_n += texture_->force(surface.texture, sample.v_SD, normal, std::abs(pressed_n), surface_sample.dt_s);
  if (surface.tap.is_on()) {
    if (begins) surface.tap.begin(-surface_sample.newest_v.dot(normal), sample.time_s, state.tap);
    force_n += surface.tap.force(sample.time_s, state.tap) * normal;
  }
  if (surface.snap.is_on()) SurfaceSnap::touch(contact.p_SP, normal, state.snap);
  return force_n;
}

// Adds the friction of an image, or that of the material if the method computes none: a spring along the surface.
void EffectStep::add_friction(const SurfaceSample& surface_sample, const SurfaceEffects& surface, const MapSample& map, const Press& press,
                              Vec3& force_n) noexcept {
  const bool has_friction_map = surface.maps.friction.is_on();
  if (!(has_friction_map || surface.drag.has_friction()) || !(press.method_n > 0.0)) {
    friction_ = {};
    return;
  }
  const auto coefficients = has_friction_map ? SpringFriction::Coefficients{map.friction, map.friction} : surface.drag.friction;
  // In its layer, method smooth has a force at almost no depth, which would make this spring too stiff.
  const double spring_n_per_m = std::min(press.method_n / press.depth_m, surface.drag.stiffness_n_per_m);
  force_n += SpringFriction::force(press.begins ? Vec3(Vec3::Zero()) : surface_sample.motion, press.normal, spring_n_per_m,
                                   std::abs(press.normal_n), coefficients, friction_);
}

// The end of contact: layers are whole again and vibrations end; a surface that snaps still attracts.
Vec3 EffectStep::leave_surface(const EffectSample& sample) noexcept {
  is_in_contact_ = false;
  friction_ = {};
  if (touched_object_ < 0) return Vec3::Zero();
  const auto object = static_cast<std::size_t>(touched_object_);
  SurfaceSnap::State& snap = states_[object].effects.snap;
  const int number = frame_of(touched_object_);
  if (number == kStill) return surfaces_[object].snap.force(sample, snap);
  const SurfaceFrame& frame = frames_[static_cast<std::size_t>(number)];
  if (frame.has_jumped()) snap = {};
  EffectSample sample_in_frame = sample;
  sample_in_frame.p_SD = frame.p_FD();
  return frame.axes() * surfaces_[object].snap.force(sample_in_frame, snap);
}

Vec3 EffectStep::space_force(const EffectSample& sample, std::uint32_t buttons) noexcept {
  Vec3 sum = Vec3::Zero();
  for (auto& [effect, burst, mass, switch_state] : space_) {
    const bool is_pressed = effect.on.update(buttons, sample.time_s, switch_state);
    if (effect.on.button == 0) {
      sum += std::visit(ForceOf{sample, burst, mass}, effect.effect);
    } else if (const auto* started = std::get_if<BurstEffect>(&effect.effect)) {
      sum += started->force_on_press(sample, is_pressed, burst);
    } else if (const auto* towed = std::get_if<MassEffect>(&effect.effect)) {
      sum +=
          switch_state.gain * towed->force(sample, mass);  // follows the hand while the button is up, so that a press begins without a jolt
    } else if (switch_state.gain > 0.0) {
      EffectSample since_press = sample;
      since_press.time_s -= switch_state.began_s;
      sum += switch_state.gain * std::visit(ForceOf{since_press, burst, mass}, effect.effect);
    }
  }
  return sum;
}

}  // namespace hapton
