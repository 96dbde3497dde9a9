#include "patch/patch_chain.h"

#include <algorithm>
#include <utility>

#include "core/math/rigid_pose.h"
#include "link/commanded_move.h"

namespace hapton {

PatchChain::PatchChain() : touches_(kLinks) { p_OD_.fill(Vec3::Zero()); }

std::unique_ptr<PatchBodies> PatchChain::take(std::unique_ptr<PatchBodies> bodies) noexcept {
  note_single_proxy();
  std::swap(bodies_, bodies);
  if (bodies != nullptr && bodies->effects != nullptr && bodies_->effects != nullptr)
    bodies_->effects->continue_hand_motion(*bodies->effects);
  has_arrived_ = false;
  has_new_bodies_ = true;
  proxy_.set_extent(bodies_->extent_m);
  proxy_.forget();
  for (std::size_t b = 0; b < body_count(); ++b) {
    const PatchBodyMotion& body = bodies_->bodies[b];
    commanded_[b] = AnnouncedMotion(body.pivot_S, body.radius_m);
  }
  most_bodies_ = std::max(most_bodies_, body_count());
  return bodies;
}

// In the order in which they were taken, so that a move still takes effect before the move that has replaced it.
void PatchChain::note_moves(const MoveTable& moves) noexcept {
  moves.visit_recent([this](const ObjectMove& move) { note_move(move); });
  for (const ObjectMove& move : moves.moves()) note_move(move);
}

void PatchChain::note_move(const ObjectMove& move) noexcept {
  for (std::size_t b = 1; b < body_count(); ++b) {
    if (!bodies_->bodies[b].is_commanded || bodies_->bodies[b].object != move.object) continue;
    AnnouncedMotion& motion = commanded_[b];
    const std::uint64_t late_before = motion.late();
    (void)(has_arrived_ ? motion.accept_in_contact(to_command(move), time_s_) : motion.accept(to_command(move)));
    late_moves_ += motion.late() - late_before;
  }
}

std::unique_ptr<PatchMaterials> PatchChain::take(std::unique_ptr<PatchMaterials> materials) noexcept {
  std::swap(materials_, materials);
  for (PatchTouch& touch : touches_) touch.use_materials(*materials_);
  return materials;
}

std::unique_ptr<Patch> PatchChain::offer(std::size_t link, std::unique_ptr<Patch> patch) noexcept {
  auto superseded = touches_[link].offer(std::move(patch));
  if (materials_ != nullptr) touches_[link].use_materials(*materials_);
  return superseded;
}

void PatchChain::forget() noexcept {
  for (PatchTouch& touch : touches_) touch.forget();
  if (bodies_ != nullptr && bodies_->effects != nullptr) bodies_->effects->forget();
  proxy_.forget();
  has_arrived_ = false;
  start_.reset();
}

void PatchChain::set_generation(std::uint32_t generation) noexcept {
  if (std::exchange(generation_, generation) == generation) return;
  note_single_proxy();
  for (PatchTouch& touch : touches_) touch.set_generation(generation);
  has_arrived_ = false;
}

Pose PatchChain::pose_of(std::size_t body, double time_s) const noexcept {
  if (bodies_ == nullptr || body >= bodies_->bodies.size()) return Pose::Identity();
  const PatchBodyMotion& body_motion = bodies_->bodies[body];
  if (body_motion.is_commanded) return commanded_[body].pose_at(time_s);
  return body_motion.keyframes != nullptr ? body_motion.keyframes->pose_at(time_s) : Pose(Pose::Identity());
}

void PatchChain::start_at(const Vec3& p_SP, const Vec3& outward, double age_s, double time_s) noexcept {
  has_arrived_ = false;
  start_ = {p_SP, outward, time_s};
  for (std::size_t b = 0; b < body_count(); ++b) start_body(b, *start_, age_s);
  proxy_.go_on_from(p_SP);
}

void PatchChain::start_body(std::size_t body, const Start& start, double age_s) noexcept {
  const Pose X_SO = pose_of(body, start.time_s);
  touches_[body].start_at(to_frame(X_SO, start.p_SP), X_SO.linear().transpose() * start.outward, age_s);
}

// Called once the places of the new bodies are known. Body 0, which stands still, has already continued from the proxy.
void PatchChain::start_new_bodies() noexcept {
  has_new_bodies_ = false;
  if (!start_) return;
  for (std::size_t b = 1; b < body_count(); ++b) start_body(b, *start_, 0.0);
  proxy_.go_on_from(start_->p_SP);
}

// With a single body nothing else notes the proxy; the bodies that replace this one start there.
void PatchChain::note_single_proxy() noexcept {
  if (has_arrived_ && body_count() == 1) start_ = {touches_[0].proxy(), touches_[0].outward(), time_s_};
}

void PatchChain::note_proxy(const Vec3& p_SD, const MethodOutput& felt) noexcept {
  start_ = {felt.p_SP, felt.contact ? Vec3((felt.p_SP - p_SD).normalized()) : Vec3(Vec3::Zero()), time_s_};
}

bool PatchChain::is_ready() const noexcept {
  if (bodies_ == nullptr) return true;
  if (bodies_->generation != generation_) return false;
  for (std::size_t b = 1; b < bodies_->bodies.size(); ++b) {
    if (commanded_[b].serial() < bodies_->bodies[b].move_serial) return false;
  }
  return true;
}

class PatchChain::Places final : public BodyPlaces {
 public:
  Places(const PatchChain& chain, double time_s) : chain_(chain), time_s_(time_s) {}

  Pose pose(std::size_t body) const noexcept override { return chain_.pose_of(body, time_s_); }
  std::optional<SurfacePlace> place(std::size_t body, int object) const noexcept override {
    return body < kLinks ? chain_.touches_[body].find_place(object) : std::nullopt;
  }
  double stiffness(std::size_t body, int object) const noexcept override {
    return body < kLinks ? chain_.touches_[body].stiffness_of(object) : std::numeric_limits<double>::infinity();
  }

 private:
  const PatchChain& chain_;
  double time_s_;
};

std::optional<PatchOutput> PatchChain::step(const TouchInput& input) noexcept {
  std::optional<PatchOutput> output = step_bodies(input);
  if (bodies_ != nullptr && bodies_->effects != nullptr) [[unlikely]]
    bodies_->effects->add(input, Places(*this, input.time_s), output);
  return output;
}

std::optional<PatchOutput> PatchChain::step_bodies(const TouchInput& input) noexcept {
  time_s_ = input.time_s;
  if (body_count() > 1) return step_chain(input);
  p_OD_[0] = to_frame(input.X_WS, input.p_WD);
  std::optional<PatchOutput> output = touches_[0].step(input);
  if (!is_ready()) return std::nullopt;
  has_arrived_ = touches_[0].has_arrived();
  return output;
}

// A part for which no force can be computed yet gives none: its proxy is reported where the device point is.
class PatchChain::ChainParts final : public FeltParts {
 public:
  ChainParts(PatchChain& chain, const TouchInput& input) : chain_(chain), input_(input) {}

  Pose pose(std::size_t part) const noexcept override { return chain_.pose_of(part, input_.time_s); }
  void reset(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept override { (void)resume(part, X_SO, p_S); }
  bool resume(std::size_t part, const Pose& X_SO, const Vec3& p_S) noexcept override {
    // Fails if the proxy before this sample is unknown, or may be inside the part's present shape.
    if (chain_.deforms(part) || !chain_.had_force_[part] || chain_.touches_[part].is_beyond()) return false;
    chain_.touches_[part].go_on_from(to_frame(X_SO, p_S));
    return true;
  }
  MethodOutput feel(std::size_t part, const Pose& X_SO, const Vec3& p_S, const Turn& turn) noexcept override {
    PatchTouch& touch = chain_.touches_[part];
    if (!turn.is_correction) chain_.p_OD_[part] = to_frame(X_SO, p_S);
    touch.set_shared(turn.is_shared);
    const std::optional<PatchOutput> felt =
        touch.step({.p_WD = p_S, .X_WS = X_SO, .dt_s = input_.dt_s, .time_s = input_.time_s, .is_correction = turn.is_correction});
    MethodOutput output{.force_n = Vec3::Zero(), .p_SP = p_S};
    chain_.has_force_[part] = felt.has_value();
    if (!felt) {
      chain_.has_all_forces_ = false;
      return output;
    }
    // A correction begins the same sample again: no other patch has taken over.
    sum.is_handed_over = sum.is_handed_over || (felt->is_handed_over && !turn.is_correction);
    sum.is_beyond = sum.is_beyond || felt->is_beyond;
    sum.difference_n += felt->difference_n;
    const bool is_held = !felt->is_beyond && touch.proxy() != touch.device();
    if (is_held) output.p_SP = X_SO * touch.proxy();
    if (!felt->contact) return output;
    if (!is_held) output.p_SP = p_S + felt->visual_offset_m;
    output.force_n = felt->force_n;
    output.contact = true;
    output.object = felt->object;
    return output;
  }

  PatchOutput sum;

  StiffnessRange stiffness(std::size_t part) const noexcept override { return chain_.touches_[part].stiffness(); }
  bool is_frictionless(std::size_t part) const noexcept override { return chain_.touches_[part].is_frictionless(); }
  double damping(std::size_t part, int object) const noexcept override { return chain_.touches_[part].damping_of(object); }

 private:
  PatchChain& chain_;
  const TouchInput& input_;
};

std::optional<PatchOutput> PatchChain::step_chain(const TouchInput& input) noexcept {
  const Vec3 p_SD = to_frame(input.X_WS, input.p_WD);
  if (!p_SD.allFinite()) return std::nullopt;
  if (has_new_bodies_ && is_ready()) start_new_bodies();
  has_all_forces_ = true;
  had_force_ = has_force_;
  ChainParts bodies(*this, input);
  const MethodOutput felt = proxy_.step(bodies, body_count(), true, p_SD, input.dt_s);
  PatchOutput& sum = bodies.sum;
  if (!has_all_forces_ || !is_ready()) {
    has_arrived_ = false;
    return std::nullopt;
  }
  has_arrived_ = true;
  note_proxy(p_SD, felt);
  sum.contact = felt.contact;
  sum.object = felt.object;
  if (felt.contact) {
    sum.force_n = input.X_WS.linear() * felt.force_n;
    sum.visual_offset_m = input.X_WS.linear() * (felt.p_SP - p_SD);
  }
  sum.difference_n = input.X_WS.linear() * sum.difference_n;
  return sum;
}

PatchTouch::Counts PatchChain::counts() const noexcept {
  PatchTouch::Counts sum;
  sum.late_moves = late_moves_;
  for_each_link([&](std::size_t link) {
    const PatchTouch::Counts& one = touches_[link].counts();
    sum.steps += one.steps;
    sum.contact_steps += one.contact_steps;
    sum.followed += one.followed;
    sum.handed_over += one.handed_over;
    sum.beyond += one.beyond;
    sum.beyond_steps += one.beyond_steps;
    sum.raised += one.raised;
    sum.begun_anew += one.begun_anew;
    sum.shapes += one.shapes;
    sum.late_shapes += one.late_shapes;
  });
  return sum;
}

}  // namespace hapton
