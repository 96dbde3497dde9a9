#include "core/force/touch_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

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
  sample.is_correction = input.is_correction;
  sample.buttons = input.buttons;
  sample.touch = &input;
  return sample;
}

// Null: the object has no images.
std::unique_ptr<MapFinder> make_finder(const TouchScene& scene, std::size_t object) {
  const SurfaceMaps& maps = scene.objects[object].effects.maps;
  if (!maps.is_on()) return nullptr;
  const auto prepared = object < scene.mapped.size() ? scene.mapped[object] : nullptr;
  if (prepared != nullptr && prepared->triangles() == maps.triangles) return std::make_unique<MapFinder>(maps, prepared);
  return std::make_unique<MapFinder>(maps);
}

}  // namespace

TouchStep::TouchStep(std::shared_ptr<ForceMethod> method, const TouchScene& scene)
    : method_(std::move(method)), has_motion_(scene.has_motion()) {
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    if (const auto& pivot = scene.objects[o].command_pivot) commanded_.push_back({static_cast<int>(o), CommandedMotion(*pivot)});
  }
  X_SO_.resize(commanded_.size(), Pose::Identity());
  const bool adds_drag = !method_->unrendered_drag().empty();
  if (!scene.has_effects() && !adds_drag) return;
  std::vector<SurfaceEffects> surfaces;
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    surfaces.push_back(scene.objects[o].effects);
    surfaces.back().drag.stiffness_n_per_m = scene.objects[o].material.stiffness_n_per_m;
    has_layers_ = has_layers_ || surfaces.back().layers.is_on();
    maps_.push_back(make_finder(scene, o));
  }
  auto frames = std::make_unique<EffectFrames>(scene);
  effects_ = std::make_unique<EffectStep>(std::move(surfaces), scene.effects, frames->of_objects());
  if (!frames->of_objects().empty()) frames_ = std::move(frames);
  const auto has_drag = [](const TouchObject& object) {
    return object.material.friction_static > 0.0 || object.material.damping_ns_per_m > 0.0;
  };
  uses_effects_ = effects_->any() || (adds_drag && std::any_of(scene.objects.begin(), scene.objects.end(), has_drag));
}

// Adds damping and friction of the materials as surface effects, if the method renders neither.
void TouchStep::update_drag() noexcept {
  has_set_drag_ = true;
  const std::span<const Material> materials = method_->unrendered_drag();
  for (std::size_t o = 0; o < materials.size(); ++o) {
    const Material& material = materials[o];
    effects_->set_drag(o, {.damping_ns_per_m = material.damping_ns_per_m,
                           .stiffness_n_per_m = material.stiffness_n_per_m,
                           .friction = {material.friction_static, material.friction_dynamic}});
  }
}

void TouchStep::set_materials(std::span<const Material> materials) noexcept {
  method_->set_materials(materials);
  if (effects_ == nullptr) return;
  for (std::size_t o = 0; o < std::min(materials.size(), maps_.size()); ++o)
    effects_->set_drag(o, {.stiffness_n_per_m = materials[o].stiffness_n_per_m});
  update_drag();
  const bool used_effects = std::exchange(uses_effects_, effects_->any());
  if (!uses_effects_) held_offset_m_.reset();
  has_new_effects_ = uses_effects_ && (has_new_effects_ || !used_effects);
}

TouchOutput TouchStep::step(const TouchInput& input) noexcept {
  MethodInput sample = to_static_scene(input);
  if (has_motion_) [[unlikely]] {
    place_commanded(input.time_s);
    sample.commanded = X_SO_;
  }
  const MethodOutput result = method_->step(sample);
  // One variable for all returns, so that it is built in the caller's storage and never copied.
  TouchOutput output;
  output.contact = result.contact;
  output.object = result.object;
  if (result.contact) {
    output.force_n = input.X_WS.linear() * result.force_n;
    output.visual_offset_m = input.X_WS.linear() * (result.p_SP - sample.p_SD);
  }
  if (uses_effects_) [[unlikely]]
    output = add_effects(input, sample, result);
  return output;
}

// Corrects the last device point of the effects after the view transform has changed: this is not a motion of the hand. A sample that is
// not finite is left out: the effects continue from the sample before it.
void TouchStep::compensate_scene_motion(const TouchInput& input) noexcept {
  if (!input.p_WD.allFinite()) return;
  if (last_input_.X_WS.matrix() != input.X_WS.matrix())
    effects_->note_scene_moved(to_static_scene({.p_WD = last_input_.p_WD, .X_WS = input.X_WS}).p_SD);
  last_input_ = input;
}

Vec3 TouchStep::step_in_space(const TouchInput& input) noexcept {
  if (!uses_effects_) return Vec3::Zero();
  held_offset_m_.reset();
  if (has_new_effects_) reset_effects(input);
  compensate_scene_motion(input);
  return input.X_WS.linear() * effects_->step_in_space(to_static_scene(input).p_SD, input.dt_s, input.buttons);
}

// Not inlined, for the same reason as add_effects: it would slow down every step without moving effects.
[[gnu::noinline]] std::optional<SurfacePlace> TouchStep::place_frames(const MethodInput& sample, const MethodOutput& result) noexcept {
  effects_->place(frames_->place(sample));
  return result.contact && result.object >= 0 ? method_->find_place(result.object) : std::nullopt;
}

// The position of the proxy on the mesh at rest, where the images are defined.
Vec3 TouchStep::find_at_rest(const MethodOutput& result, const std::optional<SurfacePlace>& place) const noexcept {
  if (place) return place->p_rest;
  return frames_ != nullptr ? frames_->at_rest(result.object, result.p_SP) : result.p_SP;
}

// Not inlined: its registers and stack would slow down every step of a scene without effects.
[[gnu::noinline]] TouchOutput TouchStep::add_effects(const TouchInput& input, const MethodInput& sample,
                                                     const MethodOutput& result) noexcept {
  if (has_new_effects_) reset_effects(input);
  if (!has_set_drag_) update_drag();
  compensate_scene_motion(input);
  MethodOutput without_body = result;
  const BodyPush body = method_->body_push();
  const bool has_body = !body.force_n.isZero(0.0) || !body.extension_m.isZero(0.0);
  if (has_body) [[unlikely]] {
    without_body.force_n -= body.force_n;
    without_body.p_SP -= body.extension_m;
  }
  SurfaceContact contact = {
      .force_n = without_body.force_n, .p_SP = without_body.p_SP, .object = without_body.object, .contact = without_body.contact};
  std::optional<SurfacePlace> place;
  if (frames_ != nullptr) [[unlikely]] {
    place = place_frames(sample, without_body);
    if (place) contact.place = &*place;
  }
  std::optional<MapSample> map;
  if (without_body.contact && without_body.object >= 0 && without_body.object < static_cast<int>(maps_.size())) {
    if (MapFinder* finder = maps_[static_cast<std::size_t>(without_body.object)].get()) {
      contact.map = &map.emplace(finder->find(find_at_rest(without_body, place)));
    }
  }
  EffectResult felt = effects_->step(sample.p_SD, sample.dt_s, contact, input.buttons);
  held_offset_m_.reset();
  if (contact.contact && felt.p_SP != contact.p_SP) held_offset_m_ = input.X_WS.linear() * (contact.p_SP - sample.p_SD);
  if (has_body) [[unlikely]] {
    felt.force_n += body.force_n;
    felt.p_SP += body.extension_m;
    felt.is_felt = true;
  }
  TouchOutput output;
  output.contact = felt.is_felt;
  output.object = result.object;
  if (felt.is_felt) output.force_n = input.X_WS.linear() * felt.force_n;
  if (result.contact) output.visual_offset_m = input.X_WS.linear() * (felt.p_SP - sample.p_SD);
  return output;
}

// Computes the poses at this time. After the end of all moves they do not change.
void TouchStep::place_commanded(double time_s) noexcept {
  if (placed_s_ >= commanded_until_s_ && time_s >= placed_s_) return;
  for (std::size_t n = 0; n < commanded_.size(); ++n) X_SO_[n] = commanded_[n].motion.pose_at(time_s);
  placed_s_ = time_s;
}

bool TouchStep::command(int object, const CommandedMove& move) noexcept {
  const auto found = std::ranges::find(commanded_, object, &Commanded::object);
  if (found == commanded_.end() || !found->motion.begin(move)) return false;
  // A move that takes no time counts, too.
  placed_s_ = std::min(placed_s_, move.from.time_s);
  commanded_until_s_ = std::max(commanded_until_s_, std::nextafter(move.to.time_s, std::numeric_limits<double>::infinity()));
  return true;
}

const CommandedMotion* TouchStep::find_commanded(int object) const noexcept {
  const auto found = std::ranges::find(commanded_, object, &Commanded::object);
  return found != commanded_.end() ? &found->motion : nullptr;
}

std::vector<int> TouchStep::commanded_objects() const {
  std::vector<int> objects;
  for (const Commanded& each : commanded_) objects.push_back(each.object);
  return objects;
}

void TouchStep::continue_hand_motion(const TouchStep& other) noexcept {
  if (!uses_effects_ || !other.uses_effects_ || other.has_new_effects_) return;
  effects_->continue_hand_motion(*other.effects_);
  last_input_ = other.last_input_;
}

void TouchStep::copy_commands(const TouchStep& other) noexcept {
  if (commanded_.size() != other.commanded_.size()) return;
  std::copy(other.commanded_.begin(), other.commanded_.end(), commanded_.begin());
  placed_s_ = -std::numeric_limits<double>::infinity();
  commanded_until_s_ = other.commanded_until_s_;
}

void TouchStep::reset(const TouchInput& input) noexcept {
  method_->reset(to_static_scene(input).p_SD);
  reset_effects(input);
}

void TouchStep::resume(const TouchInput& input) noexcept {
  method_->resume(to_static_scene(input).p_SD);
  reset_effects(input);
}

void TouchStep::reset_effects(const TouchInput& input) noexcept {
  has_new_effects_ = false;
  held_offset_m_.reset();
  if (effects_ == nullptr) return;
  effects_->reset();
  last_input_ = input;
}

}  // namespace hapton
