#include "core/force/sculpt/sculpt_method.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace hapton {
namespace {

// Most turns of a body in a sample: a body that does not agree with the others by then goes on in the next sample. Bounds the time of a
// step (decision 246 has the times).
constexpr int kMaxTurns = 2;

// Hooke's law, less damping along the extension; damping never makes the force attractive.
Vec3 force_of(const Material& material, const Vec3& extension_m, const Vec3& change_m, double dt_s) {
  const double length = extension_m.norm();
  if (!(length > 0.0)) return Vec3::Zero();
  const Vec3 direction = extension_m / length;
  const double speed = dt_s > 0.0 ? change_m.dot(direction) / dt_s : 0.0;
  return std::max(0.0, material.stiffness_n_per_m * length + material.damping_ns_per_m * speed) * direction;
}

}  // namespace

SculptMethod::SculptMethod(SceneParts others, std::size_t bodies, bool has_proxy)
    : others_(std::move(others)), proxy_(others_.size() + bodies, others_.extent_m(), !has_proxy) {
  bodies_.reserve(bodies);
}

Result<std::unique_ptr<ForceMethod>> SculptMethod::make(SceneParts::Make make, bool has_proxy, const MethodSettings& settings,
                                                        const TouchScene& scene) {
  auto others = SceneParts::make(make, settings, scene);
  if (!others) return tl::unexpected(others.error());
  const auto bodies = std::ranges::count_if(scene.objects, [](const TouchObject& object) { return object.sculpt.has_value(); });
  std::unique_ptr<SculptMethod> method(new SculptMethod(std::move(*others), static_cast<std::size_t>(bodies), has_proxy));
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const TouchObject& object = scene.objects[o];
    if (!object.sculpt) continue;
    if (auto added = method->sculpture_->add(static_cast<int>(o), *object.sculpt, *object.mesh); !added) {
      return fail("object {} cannot be carved: {}", o, added.error().what);
    }
    method->carve_buttons_ |= object.sculpt->button;
    method->bodies_.push_back({.ball = CarvingBall(*object.sculpt), .material = object.material});
  }
  for (std::size_t part = 0; part < method->others_.size(); ++part) {
    if (!method->others_.method(part).unrendered_drag().empty()) method->unrendered_drag_.resize(scene.objects.size());
  }
  method->update_unrendered_drag();
  return std::unique_ptr<ForceMethod>(std::move(method));
}

void SculptMethod::update_unrendered_drag() noexcept {
  if (unrendered_drag_.empty()) return;
  for (std::size_t part = 0; part < others_.size(); ++part) {
    const std::span<const Material> part_drag = others_.method(part).unrendered_drag();
    for (std::size_t i = 0; i < part_drag.size(); ++i) unrendered_drag_[others_.objects(part)[i]] = part_drag[i];
  }
}

class SculptMethod::Parts final : public FeltParts {
 public:
  Parts(SculptMethod& method, const MethodInput& input) : method_(method), input_(input) { method.others_.begin(input); }

  Pose pose(std::size_t part) const noexcept override { return is_other(part) ? others().pose(part) : Pose(Pose::Identity()); }
  void reset(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept override {
    if (is_other(part)) return others().reset(part, X_SO, p_S);
    Body& own = method_.bodies_[body(part)];
    own.ball.reset(p_S);
    own.extension_m.setZero();
  }
  // The state of a body before the sample is known, so the body can always go on from there.
  bool resume(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept override {
    if (is_other(part)) return others().resume(part, X_SO, p_S);
    method_.bodies_[body(part)].ball.restart_sample();
    return true;
  }
  MethodOutput feel(std::size_t part, const Pose& X_SO, const Vec3& p_S, const Turn& turn) noexcept override {
    return is_other(part) ? others().feel(part, X_SO, p_S, turn) : method_.feel(body(part), input_, p_S, turn);
  }
  bool may_give_way() const noexcept override { return (input_.buttons & method_.carve_buttons_) != 0; }
  bool gives_way(std::size_t part) const noexcept override { return !is_other(part) && method_.cuts(body(part), input_); }
  void settle(std::size_t part, const Vec3& p_S) noexcept override {
    const CarvedField& field = method_.sculpture_->bodies()[body(part)].field;
    method_.bodies_[body(part)].ball.settle(field, p_S, input_.p_SD);
  }
  int most_turns(std::size_t part) const noexcept override { return is_other(part) ? FeltParts::most_turns(part) : kMaxTurns; }
  StiffnessRange stiffness(std::size_t part) const noexcept override {
    if (is_other(part)) return others().stiffness(part);
    const double own = method_.bodies_[body(part)].material.stiffness_n_per_m;
    return {own, own};
  }
  bool is_frictionless(std::size_t part) const noexcept override {
    return is_other(part) ? others().is_frictionless(part) : method_.bodies_[body(part)].material.friction_dynamic == 0.0;
  }
  double damping(std::size_t part, int object) const noexcept override {
    return is_other(part) ? others().damping(part, object) : method_.bodies_[body(part)].material.damping_ns_per_m;
  }

 private:
  SceneParts& others() const noexcept { return method_.others_; }
  bool is_other(std::size_t part) const noexcept { return part < others().size(); }
  std::size_t body(std::size_t part) const noexcept { return part - others().size(); }

  SculptMethod& method_;
  const MethodInput& input_;
};

bool SculptMethod::cuts(std::size_t body, const MethodInput& input) const noexcept {
  return bodies_[body].ball.cuts((input.buttons & sculpture_->bodies()[body].settings.button) != 0, *sculpture_);
}

MethodOutput SculptMethod::feel(std::size_t body, const MethodInput& input, const Vec3& goal, const FeltParts::Turn& turn) noexcept {
  Body& felt_body = bodies_[body];
  const bool is_down = (input.buttons & sculpture_->bodies()[body].settings.button) != 0;
  const Material material = turn.is_shared ? shared_material(felt_body.material) : felt_body.material;
  const CarvingBall::Felt felt = felt_body.ball.step(
      {.goal = goal, .dt_s = input.dt_s, .is_down = is_down, .is_correction = turn.is_correction}, material, *sculpture_, body);
  if (!turn.is_correction) felt_body.extension_before_m = felt_body.extension_m;
  felt_body.extension_m = felt.p_SP - goal;
  const Vec3 force = force_of(material, felt_body.extension_m, felt_body.extension_m - felt_body.extension_before_m, input.dt_s);
  if (!felt.contact) return {.force_n = Vec3::Zero(), .p_SP = goal};
  return {.force_n = force, .p_SP = felt.p_SP, .contact = true, .object = sculpture_->bodies()[body].object};
}

MethodOutput SculptMethod::step(const MethodInput& input) noexcept {
  sculpture_->begin_step();
  body_push_ = {};
  if (!input.p_SD.allFinite() || !std::isfinite(input.dt_s) || !std::isfinite(input.time_s)) {
    return {.force_n = Vec3::Zero(), .p_SP = input.p_SD};
  }
  if (!std::exchange(has_begun_, true)) {
    for (Body& body : bodies_) body.ball.reset(input.p_SD);
  }
  sculpture_->note_buttons(input.buttons, carve_buttons_);
  Parts parts(*this, input);
  const std::size_t others = others_.size();
  // Part 0 is felt last even if all other objects move: those are hard, and the bodies are not.
  const MethodOutput output = proxy_.step(parts, others + bodies_.size(), true, input.p_SD, input.dt_s);
  if (output.object >= 0 && !is_body(output.object)) {
    for (std::size_t body = 0; body < bodies_.size(); ++body) {
      body_push_.force_n += proxy_.force_of(others + body);
      body_push_.extension_m -= proxy_.share_of(others + body);
    }
  }
  held_at_ = output.contact ? std::optional(output.p_SP) : std::nullopt;
  return output;
}

bool SculptMethod::is_body(int object) const noexcept {
  return std::ranges::any_of(sculpture_->bodies(), [&](const Sculpture::Body& body) { return body.object == object; });
}

void SculptMethod::reset(const Vec3& p_SD) noexcept {
  proxy_.reset(p_SD);
  has_begun_ = true;
  held_at_.reset();
  sculpture_->begin_step();
}

void SculptMethod::resume(const Vec3& p_SP) noexcept {
  reset(p_SP);
  if (others_.size() != 1 || !others_.has_still()) return;
  // Where nothing moves, the other objects go on from exactly p_SP.
  others_.resume(0, Pose::Identity(), p_SP);
  for (Body& body : bodies_) {
    body.ball.reset(p_SP);
    body.extension_m.setZero();
  }
  proxy_.go_on_from(p_SP);
}

void SculptMethod::set_materials(std::span<const Material> materials) noexcept {
  others_.set_materials(materials);
  update_unrendered_drag();
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    const auto object = static_cast<std::size_t>(sculpture_->bodies()[body].object);
    if (object < materials.size()) bodies_[body].material = materials[object];
  }
}

void SculptMethod::exchange_sculpture(ForceMethod& other) noexcept {
  auto* same = dynamic_cast<SculptMethod*>(&other);
  if (same != nullptr && sculpture_->is_alike(*same->sculpture_)) std::swap(sculpture_, same->sculpture_);
}

bool SculptMethod::restore_sculpture(Sculpture& other, std::uint32_t undo_serial) noexcept {
  if (!sculpture_->is_alike(other)) return false;
  sculpture_->exchange_shapes(other, undo_serial);
  for (std::size_t body = 0; body < bodies_.size(); ++body) bodies_[body].ball.note_restored_material(sculpture_->bodies()[body].field);
  return true;
}

bool SculptMethod::repeat_carve(int object, const Carve& carve) noexcept {
  const std::vector<Sculpture::Body>& bodies = sculpture_->bodies();
  const auto body = std::find_if(bodies.begin(), bodies.end(), [&](const Sculpture::Body& one) { return one.object == object; });
  if (body == bodies.end() || sculpture_->is_full()) return false;
  sculpture_->begin_step();
  sculpture_->carve(static_cast<std::size_t>(body - bodies.begin()), carve);
  const bool is_made = sculpture_->made().has_value();
  sculpture_->begin_step();
  return is_made;
}

std::string SculptMethod::describe() const {
  std::string text = others_.describe();
  for (const Sculpture::Body& body : sculpture_->bodies()) {
    const std::array<int, 3>& nodes = body.field.nodes();
    text +=
        fmt::format("object {} can be carved: {} x {} x {} voxels of {:.3g} mm ({:.1f} MiB), ball of {:.3g} mm radius\n", body.object,
                    nodes[0], nodes[1], nodes[2], 1e3 * body.settings.voxel_m,
                    static_cast<double>(body.field.grid().size()) * sizeof(float) / (1024.0 * 1024.0), 1e3 * body.settings.tool_radius_m);
  }
  if (sculpture_->newest() > 0) text += fmt::format("carves: {}\n", sculpture_->newest());
  return text;
}

}  // namespace hapton
