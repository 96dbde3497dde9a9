#include "haptic_step/haptics_step.h"

#include <algorithm>
#include <utility>

#include "core/base/ns_between.h"
#include "core/math/contact_resumption.h"
#include "core/math/rigid_pose.h"

namespace hapton {
namespace {

constexpr double kFirstStepS = 1e-3;  // of a sample without one before it: a cycle at 1 kHz is assumed
// The longest gap after which this node still uses its own contact: the hub sends 20 samples a second meanwhile, and some are lost.
constexpr std::int64_t kMaxOwnContactGapNs = 200'000'000;

// Whether the hand has moved from one sample to the next on a path that the probe, or the tool, may follow.
bool is_motion_known(const TouchInput& from, const DeviceState& to, std::int64_t gap_ns, bool is_tool) noexcept {
  return is_path_known(from.p_WD, to.p_WD, gap_ns) && (!is_tool || is_turn_known(from.q_WT, to.q_WT, gap_ns));
}

// Whether both samples are finite. Others say nothing about the hand's path; they give no force.
bool are_finite(const TouchInput& from, const DeviceState& to) noexcept {
  return from.p_WD.allFinite() && from.q_WT.coeffs().allFinite() && to.p_WD.allFinite() && to.q_WT.coeffs().allFinite();
}

// The start of a probe that was at p_WP: off the surface by offset_m. None if the hand is no longer near.
std::optional<Vec3> find_start(const Vec3& p_WP, const Vec3& p_WD, double offset_m) noexcept {
  const Vec3 outward = p_WP - p_WD;
  if (!(outward.norm() > 0.0 && outward.norm() <= kResumeReachM)) return std::nullopt;
  return p_WP + offset_m * outward.normalized();
}

// The same for the position that this node remembers. None also if the hand has left the surface on the outer side.
std::optional<Vec3> find_own_start(const std::optional<Vec3>& p_WP, const Vec3& outward_W, const Vec3& p_WD, double offset_m) noexcept {
  if (!p_WP || has_left_contact(*p_WP, outward_W, p_WD)) return std::nullopt;
  return find_start(*p_WP, p_WD, offset_m);
}

}  // namespace

HapticsStep::HapticsStep(std::unique_ptr<TouchStep> touch, double offset_m) : touch_(std::move(touch)), offset_m_(offset_m) {}

void HapticsStep::hold(StylusTool* tool, std::vector<ToolPart> parts) {
  tool_ = tool;
  set_parts(std::move(parts));
}

void HapticsStep::set_grasp(Grasp* grasp, std::vector<ToolPart> parts) {
  grasp_ = grasp;
  set_parts(std::move(parts));
}

void HapticsStep::set_parts(std::vector<ToolPart> parts) {
  tool_parts_ = std::move(parts);
  X_SO_.assign(tool_parts_.size(), Pose::Identity());
}

void HapticsStep::offer(const DeviceState& state) noexcept {
  if (has_state_) {
    ++skipped_;
    ++counts_.skipped;
  }
  const std::int64_t gap_ns = ns_between(last_time_ns_, state.sample_time_ns);
  if (is_running_ && state.is_resumed && !state_.is_resumed) {
    // The hub has computed the force and wants this node to continue at the hub's probe. If objects can be picked up, that probe may be
    // from before one was put down: this node also keeps its own contact, but not after a longer gap, as the hand may have gone around it.
    restart_here(grasp_ != nullptr && tool_ == nullptr && output_.contact && gap_ns <= kMaxOwnContactGapNs);
    begins_within_session_ = true;
  } else if (is_running_ && !is_thinned_ && are_finite(input_, state) && !is_motion_known(input_, state, gap_ns, tool_ != nullptr)) {
    restart_here(output_.contact);
    begins_within_session_ = true;
  }
  state_ = state;
  has_state_ = true;
}

ForceCommand HapticsStep::reply() noexcept {
  has_state_ = false;
  const std::int64_t step_ns = ns_between(last_time_ns_, state_.sample_time_ns);
  // In a new session a tool continues from its last pose, if the scene has not turned and the hand is still near.
  const bool is_tool_near =
      !is_running_ && tool_ != nullptr && input_.X_WS.matrix() == X_WS_.matrix() && is_motion_known(input_, state_, kLongGapNs, true);
  input_.dt_s = is_running_ && step_ns > 0 ? 1e-9 * static_cast<double>(step_ns) : kFirstStepS;
  input_.p_WD = state_.p_WD;
  input_.q_WT = state_.q_WT;
  input_.X_WS = X_WS_;
  input_.buttons = state_.buttons;
  last_time_ns_ = state_.sample_time_ns;
  advance_scene(step_ns);
  ForceCommand reply;
  const bool begins = !is_running_;
  reply.carve_serial = touch_->newest_carve_serial();
  if (tool_ != nullptr || grasp_ != nullptr) reply.haptons = 0;
  if (grasp_ != nullptr) update_grasp();
  if (tool_ != nullptr) {
    render_tool(reply, is_tool_near);
  } else if (grasp_ != nullptr && grasp_->is_waiting()) {
    render_space_effects(reply);
  } else {
    render_probe(reply);
  }
  // The torque of a tool that was put down fades; otherwise a probe has no torque.
  reply.torque_nm = torque_fade_.step(reply.torque_nm, reply.contact, input_.dt_s);
  if (effects_ != nullptr) add_effects(reply, begins);
  // In every reply of a scene with layers: that it is set does not indicate contact.
  if (touch_->has_layers()) reply.held_offset_m = touch_->held_offset().value_or(reply.visual_offset_m);
  last_sample_ = state_.sample;
  begins_within_session_ = false;
  ++counts_.replied;
  counts_.contact_steps += reply.contact ? 1 : 0;
  counts_.max_force_n = std::max(counts_.max_force_n, reply.force_n.norm());
  counts_.max_torque_nm = std::max(counts_.max_torque_nm, reply.torque_nm.norm());
  reply.echo_sample = state_.sample;
  reply.echo_sample_time_ns = state_.sample_time_ns;
  reply.skipped_samples = std::exchange(skipped_, 0U);
  reply.view_revision = view_.revision;
  reply.method_serial = static_cast<std::uint32_t>(counts_.method_changes);
  reply.replied_before = replied_before_;
  reply.material_serial = static_cast<std::uint32_t>(counts_.materials_taken);
  reply.scene_time_ns = scene_time_ns_;
  reply.move_serial = static_cast<std::uint32_t>(counts_.moves_taken);
  reply.shape_serial = static_cast<std::uint32_t>(counts_.shapes_applied);
  return reply;
}

bool HapticsStep::command(int object, const CommandedMove& move) noexcept {
  if (!touch_->command(object, move)) return false;
  ++counts_.moves_taken;
  return true;
}

std::unique_ptr<ShapeStage> HapticsStep::deform(int object, std::unique_ptr<ShapeStage> stage, std::int64_t start_ns,
                                                std::int64_t end_ns) noexcept {
  ++counts_.shapes_applied;
  return touch_->find_streamed(object)->offer_at(std::move(stage), 1e-9 * static_cast<double>(start_ns),
                                                 1e-9 * static_cast<double>(end_ns - start_ns));
}

void HapticsStep::advance_scene(std::int64_t step_ns) noexcept {
  if ((is_running_ || begins_within_session_) && touch_->has_motion())
    scene_time_ns_ += std::clamp<std::int64_t>(step_ns, 0, kMaxSceneStepNs);
  // While the hub computes the force, its scene time determines where moving objects are.
  if (state_.scene_time_ns >= 0 && touch_->has_motion()) scene_time_ns_ = state_.scene_time_ns;
  scene_time_ns_ = std::exchange(next_scene_time_ns_, std::nullopt).value_or(scene_time_ns_);
  input_.time_s = 1e-9 * static_cast<double>(scene_time_ns_);
}

void HapticsStep::render_probe(ForceCommand& reply) noexcept {
  bool is_free_start = false;
  if (!is_running_) {
    const TouchInput start = make_start();
    is_free_start = start.p_WD == input_.p_WD;
    begin_at(start);
  } else {
    remember_reply();
  }
  output_ = touch_->step(input_);
  // If there is no contact at the hub's probe, the probe starts where this node had contact, if it had any.
  const bool begins = !std::exchange(is_running_, true) && state_.is_resumed && !output_.contact;
  const std::optional<Vec3> own_start =
      find_own_start(std::exchange(resume_p_WP_, std::nullopt), resume_outward_W_, input_.p_WD, offset_m_);
  free_starts_ += is_free_start && !(begins && own_start) ? 1 : 0;
  if (begins && own_start) {
    TouchInput start = input_;
    start.p_WD = *own_start;
    begin_at(start);
    output_ = touch_->step(input_);
    // As in make_start(): a recording of this session does not contain this start.
    if (!begins_within_session_) replied_before_ = kUnknownBefore;
  }
  reply.force_n = fade_.step(output_.force_n, output_.contact, input_.dt_s);
  reply.contact = output_.contact || fade_.is_active();
  reply.visual_offset_m = output_.visual_offset_m;
  reply.object = output_.object;
}

// The hand did not take the path from the start to the device: a step of no duration settles the probe, so that damping does not act on
// that path. In a scene that can be carved there is no such step: it would count as a second press of the button.
void HapticsStep::begin_at(const TouchInput& start) noexcept {
  touch_->reset(start);
  if (start.p_WD == input_.p_WD || touch_->has_sculpture()) return;
  TouchInput settling = input_;
  settling.dt_s = 0.0;
  touch_->step(settling);
}

// Picks up the object that is touched, or puts down the one that is held.
void HapticsStep::update_grasp() noexcept {
  // The probe begins anew, and its contact is not known yet: an object that is moved now would lose this contact.
  if (!is_running_ && tool_ == nullptr) return grasp_->skip_sample(state_);
  const int touched = tool_ == nullptr && output_.contact ? output_.object : -1;
  const Grasp::Change change = grasp_->update(state_, X_WS_, touched, output_.visual_offset_m);
  if (change == Grasp::Change::none) return;
  tool_ = grasp_->tool();
  is_tool_blocked_ = is_tool_in_contact_ = false;
  fade_.begin();
  torque_fade_.begin();
  // A recording counts this as a change of method.
  if (change == Grasp::Change::picked_up || change == Grasp::Change::returned) ++counts_.method_changes;
  output_ = {};
  if (change == Grasp::Change::returned) return_probe();
}

// The object is back at its place before the pick-up, and the probe continues outside of it from its last position. If an obstacle
// keeps it too far from the hand, it starts where the object was touched, as after an object was put down.
void HapticsStep::return_probe() noexcept {
  const std::optional<Grasp::ResumeContact> start = grasp_->take_resume_contact(X_WS_);
  // The step for this sample is still to come: until then no time passes for effects.
  TouchInput here = input_;
  here.dt_s = 0.0;
  if (!(touch_->step(here).visual_offset_m.norm() > kResumeReachM)) return;
  TouchInput off_surface = here;
  if (start) off_surface.p_WD = start->p_W + offset_m_ * start->outward;
  touch_->reset((off_surface.p_WD - input_.p_WD).norm() <= kResumeReachM ? off_surface : here);
  touch_->step(here);
}

// An object was put down, and the slow task is building the scene with it. The present method still has the object at its old place, so
// only the effects in free space act.
void HapticsStep::render_space_effects(ForceCommand& reply) noexcept {
  if (is_running_) {
    remember_reply();
  } else {
    touch_->reset_effects(input_);
  }
  is_running_ = true;
  const Vec3 effects_n = touch_->step_in_space(input_);
  reply.force_n = fade_.step(effects_n, !effects_n.isZero(0.0), input_.dt_s);
  reply.contact = !effects_n.isZero(0.0) || fade_.is_active();
}

void HapticsStep::place_parts() noexcept {
  for (std::size_t p = 0; p < X_SO_.size(); ++p) {
    const ToolPart& part = tool_parts_[p];
    const CommandedMotion* commanded = part.commanded >= 0 ? touch_->find_commanded(part.commanded) : nullptr;
    X_SO_[p] = commanded != nullptr ? commanded->pose_at(input_.time_s) : part.pose_at(input_.time_s);
  }
}

// Reports as the object in contact, with its push, the object that the tool presses most of those that programs move.
void HapticsStep::note_push(ForceCommand& reply) const noexcept {
  for (std::size_t p = 0; p < tool_parts_.size(); ++p) {
    if (tool_parts_[p].commanded < 0) continue;
    if (!reply.push) reply.push.emplace();
    const ToolPush& push = tool_->push_on(p);
    if (!(push.force_n.squaredNorm() > reply.push->force_n.squaredNorm())) continue;
    reply.object = tool_parts_[p].commanded;
    reply.push = {push.force_n, push.torque_nm};
  }
}

// After a gap the tool continues from its last pose on a free path: it loses no contact and passes through nothing. If the hand has gone
// far meanwhile, it may have gone around something, and the tool would pull it back: then the tool begins anew. The effects of the scene
// in free space act at the grip point.
void HapticsStep::render_tool(ForceCommand& reply, bool is_near) noexcept {
  if (is_running_) {
    remember_reply();
  } else {
    touch_->reset_effects(input_);
    if (is_near) {
      tool_->forget_motion();
    } else {
      tool_->begin_anew();
    }
    free_starts_ += grasp_ == nullptr && !(is_near && tool_->is_known()) ? 1 : 0;
  }
  const bool was_known = tool_->is_known();
  is_running_ = true;
  ToolInput input;
  input.X_WD.translation() = state_.p_WD;
  input.X_WD.linear() = state_.q_WT.toRotationMatrix();
  input.X_WS = X_WS_;
  place_parts();
  input.X_SO = X_SO_;
  const ToolOutput tool_output = tool_->step(input, state_.sample_time_ns);
  // The object that was picked up gives its first force now. It may already be in contact with something, so this force fades in.
  if (grasp_ != nullptr && !was_known && tool_->is_known()) {
    fade_.begin();
    torque_fade_.begin();
  }
  is_tool_blocked_ = tool_output.proxy.is_blocked;
  is_tool_in_contact_ = tool_output.contact;
  if (tool_output.contact) counts_.haptons += static_cast<std::uint64_t>(tool_output.proxy.haptons);
  if (tool_output.contact) counts_.most_haptons = std::max(counts_.most_haptons, tool_output.proxy.haptons);
  const Vec3 effects_n = touch_->step_in_space(input_);
  const bool has_force = tool_output.contact || !effects_n.isZero(0.0);
  reply.force_n = fade_.step(tool_output.force_n + effects_n, has_force, input_.dt_s);
  reply.torque_nm = tool_output.torque_nm;
  if (tool_output.contact) reply.haptons = static_cast<std::uint32_t>(tool_output.proxy.haptons);
  reply.contact = has_force || fade_.is_active();
  if (grasp_ != nullptr) {
    grasp_->note_pose(tool_output.X_WP, X_WS_);
    reply.object = grasp_->object();
  }
  reply.visual_offset_m = tool_output.X_WP.translation() - state_.p_WD;
  reply.visual_turn = turn_between(state_.q_WT, Quat(tool_output.X_WP.linear()));
  note_push(reply);
}

// The effects of shared libraries are independent of the method: they neither fade when it changes nor move its probe.
void HapticsStep::add_effects(ForceCommand& reply, bool begins) noexcept {
  if (begins) effects_->reset();
  const PluginForce plugin_force = effects_->step({.sample = state_.sample,
                                                   .time_ns = state_.sample_time_ns,
                                                   .dt_s = input_.dt_s,
                                                   .p_WD = state_.p_WD,
                                                   .q_WT = state_.q_WT,
                                                   .buttons = state_.buttons,
                                                   .X_WS = X_WS_,
                                                   .contact = reply.contact,
                                                   .p_WP = state_.p_WD + reply.visual_offset_m,
                                                   .force_n = reply.force_n});
  reply.force_n += plugin_force.force_n;
  reply.torque_nm += plugin_force.torque_nm;
  reply.contact = reply.contact || !plugin_force.force_n.isZero(0.0) || !plugin_force.torque_nm.isZero(0.0);
}

// Where the probe starts: at the device, or off the surface, on the side on which it was in contact.
TouchInput HapticsStep::make_start() noexcept {
  const std::optional<Vec3> at = state_.is_resumed
                                     ? find_start(state_.p_WP, input_.p_WD, offset_m_)
                                     : find_own_start(std::exchange(resume_p_WP_, std::nullopt), resume_outward_W_, input_.p_WD, offset_m_);
  TouchInput start = input_;
  if (!at) return start;
  start.p_WD = *at;
  // This start depends on an earlier session, which a recording of this one does not contain.
  if (!state_.is_resumed && !begins_within_session_) replied_before_ = kUnknownBefore;
  return start;
}

void HapticsStep::announce_start() noexcept {
  const std::optional<Vec3> p_WP = resume_p_WP_;
  const std::uint64_t replied_before = replied_before_;
  input_ = {.p_WD = state_.p_WD, .X_WS = X_WS_, .dt_s = kFirstStepS, .time_s = 1e-9 * static_cast<double>(scene_time_ns_)};
  touch_->reset(make_start());
  touch_->step(input_);
  resume_p_WP_ = p_WP;
  replied_before_ = replied_before;
}

void HapticsStep::resume() noexcept {
  if (is_running_) return restart_here(output_.contact);
  // The session that has just ended had no reply: the probe still rests where it did before that session.
  const std::optional<Vec3> p_WP = resume_p_WP_;
  restart();
  resume_p_WP_ = p_WP;
}

Vec3 HapticsStep::held_offset() const noexcept { return touch_->held_offset().value_or(output_.visual_offset_m); }

// Begins anew. The probe continues from its position, if it is in contact and the scene has not been turned since.
void HapticsStep::restart_here(bool is_in_contact) noexcept {
  const Vec3 held_m = held_offset();
  restart();
  if (is_in_contact && input_.X_WS.matrix() == X_WS_.matrix()) resume_p_WP_ = input_.p_WD + held_m;
  resume_outward_W_ = held_m;
}

// Shifts the known replies by the number of samples passed, and adds the last one.
void HapticsStep::remember_reply() noexcept {
  constexpr std::uint64_t kBits = 64;  // of replied_before_
  const std::uint64_t passed = state_.sample - last_sample_;
  if (passed == 0 || passed > kBits) {
    replied_before_ = 0;
    return;
  }
  replied_before_ = (passed == kBits ? 0 : replied_before_ << passed) | (std::uint64_t{1} << (passed - 1));
}

Vec3 HapticsStep::p_STouching() const noexcept {
  const bool is_mesh_tool = tool_ != nullptr && grasp_ == nullptr;
  const Vec3 p_W = is_mesh_tool ? Vec3(input_.p_WD + input_.q_WT * tool_->vertex_m()) : input_.p_WD;
  return input_.X_WS.inverse(Eigen::Isometry) * p_W;
}

bool HapticsStep::turn_scene(const ViewTransform& view) noexcept {
  const auto pose = find_rigid_pose(view.X_WS);
  if (!pose) {
    ++counts_.views_rejected;
    return false;
  }
  ++counts_.views_applied;
  // A vision node that joins sends the present pose again: the scene has not turned then.
  if (pose->matrix() != X_WS_.matrix()) resume_p_WP_.reset();
  X_WS_ = *pose;
  view_ = view;
  return true;
}

std::unique_ptr<TouchStep> HapticsStep::replace(std::unique_ptr<TouchStep> touch) noexcept {
  ++counts_.method_changes;
  const Vec3 held_m = held_offset();
  std::swap(touch_, touch);
  touch_->copy_commands(*touch);
  touch_->exchange_carves(*touch);
  const std::optional<Grasp::ResumeContact> put_down = grasp_ != nullptr ? grasp_->take_resume_contact(X_WS_) : std::nullopt;
  if (put_down && !is_running_) {
    resume_p_WP_ = put_down->p_W;
    resume_outward_W_ = put_down->outward;
  }
  if (is_running_) {
    TouchInput start = input_;
    if (put_down && (put_down->p_W - input_.p_WD).norm() <= kResumeReachM) {
      start.p_WD = put_down->p_W + offset_m_ * put_down->outward;
    } else if (output_.contact) {
      // With effects, of the old method or the new one, the force need not point away from the surface.
      const Vec3 outward = touch->has_effects() || touch_->has_effects() ? held_m : output_.force_n;
      start.p_WD += held_m + offset_m_ * outward.normalized();
    }
    touch_->reset(start);
    // In this step the new method comes into contact and settles, on the path from its start to the device, which the hand did not take.
    TouchInput settling = input_;
    // This step is not a sample, so it must not carve.
    if (touch_->has_sculpture()) settling.buttons = 0;
    const TouchOutput settled = touch_->step(settling);
    touch_->continue_hand_motion(*touch);
    // While a tool or an object is held, the method has no output, but effects in free space may act: they begin anew.
    const bool was_held = put_down.has_value() || tool_ != nullptr;
    // The first step tells whether effects act; this step cannot, because the hand does not move in it.
    if (was_held || output_.contact || fade_.is_active() || settled.contact || touch_->has_effects()) fade_.begin();
    // This contact is kept if a new session begins, or another object is moved, before the next sample.
    if (put_down && tool_ == nullptr) output_ = settled;
  }
  return touch;
}

bool HapticsStep::restore_carves(Sculpture& other, std::uint32_t newest) noexcept {
  if (!touch_->restore_carves(other, newest)) return false;
  if (is_running_ && (output_.contact || fade_.is_active())) fade_.begin();
  return true;
}

void HapticsStep::set_materials(std::span<const Material> materials, const ToolMaterials& of_tool) noexcept {
  tool_->set_materials(of_tool);
  set_materials(materials);
  if (!is_running_ || !is_tool_in_contact_) return;
  fade_.begin();
  torque_fade_.begin();
}

void HapticsStep::set_materials(std::span<const Material> materials) noexcept {
  ++counts_.materials_taken;
  touch_->set_materials(materials);
  if (is_running_ && (output_.contact || fade_.is_active())) fade_.begin();
}

}  // namespace hapton
