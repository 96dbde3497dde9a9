#include "core/force/sculpt/sculpt_method.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/force/virtual_coupling.h"

namespace hapton {
namespace {

// Hooke's law, less damping along the extension; damping never makes the force attractive.
Vec3 force_of(const Material& material, const Vec3& extension_m, const Vec3& change_m, double dt_s) {
  const double length = extension_m.norm();
  if (!(length > 0.0)) return Vec3::Zero();
  const Vec3 direction = extension_m / length;
  const double speed = dt_s > 0.0 ? change_m.dot(direction) / dt_s : 0.0;
  return std::max(0.0, material.stiffness_n_per_m * length + material.damping_ns_per_m * speed) * direction;
}

}  // namespace

Result<std::unique_ptr<ForceMethod>> SculptMethod::make(const MethodSettings& settings, const TouchScene& scene) {
  std::unique_ptr<SculptMethod> made(new SculptMethod());
  TouchScene rest{.objects = {}, .effects = scene.effects, .part_of = scene.part_of};
  const TouchScene coupled = couple_scene(scene, settings.coupling_n_per_m);
  for (std::size_t o = 0; o < scene.objects.size(); ++o) {
    const TouchObject& object = scene.objects[o];
    if (!object.sculpt) {
      rest.objects.push_back(object);
      made->other_objects_.push_back(static_cast<int>(o));
      made->other_materials_.push_back(object.material);
      continue;
    }
    if (auto added = made->sculpture_->add(static_cast<int>(o), *object.sculpt, *object.mesh); !added) {
      return fail("object {} cannot be carved: {}", o, added.error().what);
    }
    made->carve_buttons_ |= object.sculpt->button;
    made->bodies_.push_back({.ball = CarvingBall(*object.sculpt), .material = coupled.objects[o].material});
  }
  if (!rest.objects.empty()) {
    auto others = make_method(settings, rest);
    if (!others) return tl::unexpected(others.error());
    made->others_ = std::move(*others);
    if (!made->others_->drag_left_out().empty()) made->left_out_.resize(scene.objects.size());
    made->note_left_out();
  }
  return std::unique_ptr<ForceMethod>(std::move(made));
}

void SculptMethod::note_left_out() noexcept {
  if (left_out_.empty()) return;
  const std::span<const Material> others = others_->drag_left_out();
  for (std::size_t i = 0; i < others.size(); ++i) left_out_[static_cast<std::size_t>(other_objects_[i])] = others[i];
}

void SculptMethod::feel(std::size_t body, const MethodInput& input, MethodOutput& output, double& most_n) noexcept {
  Body& own = bodies_[body];
  const Vec3 goal = output.p_SP;
  const bool is_down = (input.buttons & sculpture_->bodies()[body].settings.button) != 0;
  const CarvingBall::Felt felt = own.ball.step({.goal = goal, .dt_s = input.dt_s, .is_down = is_down}, own.material, *sculpture_, body);
  const Vec3 extension = felt.p_SP - goal;
  const Vec3 force = force_of(own.material, extension, extension - own.extension_m, input.dt_s);
  own.extension_m = extension;
  if (!felt.contact) return;
  output.p_SP = felt.p_SP;
  output.force_n += force;
  const double pushes = force.norm();
  if (!(pushes > 0.0)) return;
  output.contact = true;
  if (pushes < most_n) return;
  most_n = pushes;
  output.object = sculpture_->bodies()[body].object;
}

MethodOutput SculptMethod::step(const MethodInput& input) noexcept {
  sculpture_->begin_step();
  body_push_ = {};
  MethodOutput output{.force_n = Vec3::Zero(), .p_SP = input.p_SD};
  if (!input.p_SD.allFinite() || !std::isfinite(input.dt_s)) return output;
  if (!std::exchange(has_begun_, true)) {
    for (Body& body : bodies_) body.ball.reset(input.p_SD);
  }
  sculpture_->note_buttons(input.buttons, carve_buttons_);
  double most_n = 0.0;
  if (others_ != nullptr) {
    output = others_->step(input);
    most_n = output.force_n.norm();
    if (output.object >= 0) output.object = other_objects_[static_cast<std::size_t>(output.object)];
  }
  const MethodOutput of_others = output;
  for (std::size_t body = 0; body < bodies_.size(); ++body) feel(body, input, output, most_n);
  if (of_others.object >= 0 && output.object == of_others.object)
    body_push_ = {.force_n = output.force_n - of_others.force_n, .extension_m = output.p_SP - of_others.p_SP};
  held_at_ = output.contact ? std::optional(output.p_SP) : std::nullopt;
  return output;
}

void SculptMethod::reset(const Vec3& p_SD) noexcept {
  if (others_ != nullptr) others_->reset(p_SD);
  for (Body& body : bodies_) {
    body.ball.reset(p_SD);
    body.extension_m.setZero();
  }
  has_begun_ = true;
  held_at_.reset();
  sculpture_->begin_step();
}

void SculptMethod::resume(const Vec3& p_SP) noexcept {
  reset(p_SP);
  if (others_ != nullptr) others_->resume(p_SP);
}

std::optional<SurfacePlace> SculptMethod::find_place(int object) const noexcept {
  const auto other = std::find(other_objects_.begin(), other_objects_.end(), object);
  if (other == other_objects_.end()) return std::nullopt;
  return others_->find_place(static_cast<int>(other - other_objects_.begin()));
}

std::optional<Vec3> SculptMethod::held_at() const noexcept { return held_at_; }

void SculptMethod::set_materials(std::span<const Material> materials) noexcept {
  for (std::size_t i = 0; i < other_objects_.size(); ++i) {
    const auto object = static_cast<std::size_t>(other_objects_[i]);
    if (object < materials.size()) other_materials_[i] = materials[object];
  }
  if (others_ != nullptr) others_->set_materials(other_materials_);
  note_left_out();
  for (std::size_t body = 0; body < bodies_.size(); ++body) {
    const auto object = static_cast<std::size_t>(sculpture_->bodies()[body].object);
    if (object < materials.size()) bodies_[body].material = materials[object];
  }
}

void SculptMethod::exchange_sculpture(ForceMethod& other) noexcept {
  auto* same = dynamic_cast<SculptMethod*>(&other);
  if (same != nullptr && sculpture_->is_alike(*same->sculpture_)) std::swap(sculpture_, same->sculpture_);
}

bool SculptMethod::restore_sculpture(Sculpture& other, std::uint32_t newest) noexcept {
  if (!sculpture_->is_alike(other)) return false;
  sculpture_->exchange_shapes(other, newest);
  for (std::size_t body = 0; body < bodies_.size(); ++body) bodies_[body].ball.meet_restored(sculpture_->bodies()[body].field);
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
  std::string text = others_ != nullptr ? others_->describe() : std::string();
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
