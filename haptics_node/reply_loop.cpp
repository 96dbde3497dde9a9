#include "haptics_node/reply_loop.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "haptic_step/haptics_setup.h"
#include "runtime/log.h"

namespace hapton {
namespace {

constexpr std::int64_t kIdlePollNs = 50 * kNanosecondsPerMillisecond;  // between two polls while no state comes
constexpr std::int64_t kPatchPollNs = 4 * kNanosecondsPerMillisecond;  // the same while parts of the scene wait to be sent
constexpr int kMaxPatches = 4;                                         // parts of the scene sent between two states
constexpr std::int64_t kWaitedNs = 20'000;                             // a receive that takes longer has waited: the socket was empty
constexpr std::int64_t kHubAbsentNs = kNanosecondsPerSecond;
constexpr std::int64_t kSetupEveryNs = kNanosecondsPerSecond;
// After a change the setup is sent a few times more at this interval, because a datagram may be lost.
constexpr std::int64_t kSetupRepeatNs = 100 * kNanosecondsPerMillisecond;
constexpr int kSetupRepeats = 3;
constexpr std::size_t kMaxMoveRepeats = 16;  // moves of objects that are sent again with each setup
// Between two requests of programs that are carried out: each move is sent to every vision node.
constexpr std::int64_t kMoveEveryNs = 4 * kNanosecondsPerMillisecond;
// A shorter wait for the first reply is not reported. During a longer one vision nodes are notified at the interval below.
constexpr std::int64_t kShortWaitNs = 300 * kNanosecondsPerMillisecond;
constexpr std::int64_t kPreparingEveryNs = 200 * kNanosecondsPerMillisecond;

}  // namespace

ReplyLoop::ReplyLoop(HubClient& hub, const Clock& clock, HapticsStep& step, MethodBuilder& builder, const HapticsSetup& setup,
                     bool builds_on_approach, const SceneFacts& scene)
    : hub_(hub),
      wait_(hub, clock),
      clock_(clock),
      step_(step),
      builder_(builder),
      setup_(setup),
      method_text_(setup.method),
      scene_(scene),
      builds_on_approach_(builds_on_approach),
      start_ns_(clock.now_ns()) {}

void ReplyLoop::set_effects(PluginEffects* effects) {
  effects_ = effects;
  show_plugins();
}

// Puts the method's text into the setup, followed by the text of the effects from shared libraries.
void ReplyLoop::show_method(const HapticsSetup::Text& method) noexcept {
  setup_.method = method;
  const auto end = std::find(setup_.method.begin(), setup_.method.end(), '\0');
  const auto room = static_cast<std::size_t>(setup_.method.end() - end);
  std::copy_n(effects_text_.begin(), std::min(room, effects_text_.size()), end);
  setup_.method.back() = '\0';
}

void ReplyLoop::run(const StopSignal& stop, double seconds) {
  const std::int64_t end_ns =
      seconds > 0 ? clock_.now_ns() + static_cast<std::int64_t>(seconds * 1e9) : std::numeric_limits<std::int64_t>::max();
  while (!stop.stop_requested()) {
    const std::int64_t now_ns = clock_.now_ns();
    if (now_ns >= end_ns) {
      return;
    }
    const bool sends_patches = sends_parts(now_ns);
    turn(std::min(end_ns, now_ns + (sends_patches ? kPatchPollNs : kIdlePollNs)));
  }
}

void ReplyLoop::turn(std::int64_t deadline_ns) {
  const std::int64_t began_ns = clock_.now_ns();
  if (wait_.receive(datagram_, deadline_ns)) {
    drain(began_ns);
    if (step_.has_state()) is_ready() ? reply() : wait_for_builder();
  }
  withdraw_parts();
  if (patch_sender_ != nullptr) send_patches();
  if (carve_undo_ != nullptr) undo_carves();
  if (carve_sender_ != nullptr) send_carves();
  change_method();
  change_materials();
  move_objects();
  repeat_move();
  if (object_shaper_ != nullptr) deform_objects();
  report_grasp();
  send_setup();
  report_hub_state();
  report_scene();
  report_shown_tool();
  report_tool();
  report_inside();
  report_plugins();
  report_patches();
}

// A message that arrived after a wait is the only one in the socket: looking for a newer one would delay the reply.
void ReplyLoop::drain(std::int64_t began_ns) noexcept {
  handle(datagram_.message);
  if (hub_.receive_time_ns() - began_ns >= kWaitedNs) return;
  while (hub_.receive(datagram_, 0)) handle(datagram_.message);
}

// Sends where objects are before the first reply after a join, because another haptics node may have moved them.
void ReplyLoop::note_join() noexcept {
  if (std::exchange(handled_joins_, hub_.counts().joins) == hub_.counts().joins) return;
  send_moves();
  send_shape_starts();
  if (carve_sender_ != nullptr) hub_.send(carve_sender_->announce());
}

void ReplyLoop::handle(const Message& message) noexcept {
  if (handle_shape(message)) return;
  const bool is_overtaken = hub_.last_arrival() == Arrival::reordered;
  if (const auto* state = std::get_if<DeviceState>(&message)) {
    if (is_overtaken) {
      return;  // a newer one has its reply or is waiting
    }
    if (hub_.session() != session_) {
      session_ = hub_.session();
      is_first_reply_ = true;
      step_.resume();
    }
    note_join();
    arrival_ns_ = hub_.receive_time_ns();
    wait_.note(*state, arrival_ns_);
    // Long gaps are expected only if several states come rarely: requested parts may not have arrived yet, and this node's force be felt.
    const std::int64_t gap_ns = state->sample_time_ns - std::exchange(state_ns_, state->sample_time_ns);
    const bool are_states_rare = std::min(gap_ns, std::exchange(state_gap_ns_, gap_ns)) >= kThinnedGapNs;
    step_.set_thinned(are_states_rare && sends_parts(arrival_ns_) && !has_withdrawn());
    step_.offer(*state);
    if (patch_sender_ != nullptr && patch_sender_->is_wanted(arrival_ns_)) {
      patch_sender_->note_hand(*state, step_.view().X_WS, state->scene_time_ns >= 0 ? state->scene_time_ns : step_.scene_time_ns());
    }
  } else if (const auto* status = std::get_if<PatchStatus>(&message)) {
    if (!is_overtaken) wants_patches_ = status->is_wanted;
    if (!is_overtaken && patch_sender_ != nullptr) patch_sender_->accept(*status, hub_.receive_time_ns(), hub_.session());
  } else if (const auto* view = std::get_if<ViewTransform>(&message)) {
    if (!is_overtaken) step_.turn_scene(*view);
  } else if (const auto* scene = std::get_if<SceneFacts>(&message)) {
    shown_scene_hash_ = scene->given_hash;
    shown_tool_hash_ = scene->tool_hash;
  } else if (const auto* facts = std::get_if<LoopFacts>(&message)) {
    // While the hub gets parts of the scene, it computes the force itself, and the round trip does not matter.
    const bool is_remote = !sends_parts(hub_.receive_time_ns()) || has_withdrawn();
    if (!is_overtaken && adviser_ != nullptr && is_remote) adviser_->note(*facts);
  } else if (const auto* pose = std::get_if<ObjectPose>(&message)) {
    if (step_.grasp() != nullptr) step_.grasp()->request_pose(*pose);
  } else if (const auto* move = std::get_if<MoveRequest>(&message)) {
    if (!is_overtaken && mover_ != nullptr) mover_->request(*move);
  } else if (const auto* missing = std::get_if<CarveStatus>(&message)) {
    if (!is_overtaken && carve_sender_ != nullptr) carve_sender_->accept(*missing);
  } else if (const auto* undo = std::get_if<CarveUndo>(&message)) {
    request_undo(*undo);
  } else if (const auto* request = std::get_if<MaterialRequest>(&message)) {
    if (!is_overtaken) request_materials(*request);
  } else if (const auto* settings = std::get_if<Settings>(&message); settings != nullptr && settings->method[0] != '\0') {
    // A requester repeats its request until the reply comes.
    if (is_overtaken) return;
    if (settings->method_request != 0 && settings->method_request == last_request_) return;
    last_request_ = settings->method_request;
    if (is_holding() || object_shaper_ != nullptr) return reject_method(settings->method_request);
    builder_.request(settings->method, settings->method_request);
  }
}

// Whether the stylus holds a rigid tool, or an object is being picked up, is held or is being put down.
bool ReplyLoop::is_holding() const noexcept { return step_.holds_tool() || (step_.grasp() != nullptr && step_.grasp()->is_busy()); }

void ReplyLoop::reject_method(std::uint32_t request) noexcept {
  setup_.method_request = request;
  put_text(object_shaper_ != nullptr  ? "programs deform objects of the scene, which needs the method proxy: it stays in use"
           : step_.grasp() != nullptr ? "the stylus holds an object, and methods need a probe; put it down, then request again"
                                      : "the stylus holds a rigid tool, and methods need a probe; leave out --tool, or [tool] of the scene",
           setup_.rejection);
  send_setup_soon();
}

// False only before the first reply of a session, until the objects at the start are built. Later a contact continues on objects that are
// built. A probe that begins at the hand needs no wait: after one it would begin there as well, only farther on.
bool ReplyLoop::is_ready() noexcept {
  if (!builds_on_approach_ || !is_first_reply_ || step_.is_running() || step_.holds_tool()) return true;
  if (!idle_polls_before_) {
    idle_polls_before_ = builder_.idle_polls();
    step_.announce_start();
  }
  if (builder_.idle_polls() < *idle_polls_before_ + 2) return false;
  idle_polls_before_.reset();
  return true;
}

// Notifies vision nodes, so that people see that the node is working.
void ReplyLoop::wait_for_builder() noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  if (preparing_since_ns_ == 0) preparing_since_ns_ = now_ns;
  scene_.preparing_s = static_cast<float>(static_cast<double>(now_ns - preparing_since_ns_) * 1e-9);
  if (now_ns - preparing_since_ns_ >= kShortWaitNs) next_setup_ns_ = std::min(next_setup_ns_, setup_sent_ns_ + kPreparingEveryNs);
}

void ReplyLoop::reply() noexcept {
  if (preparing_since_ns_ != 0) {
    preparing_since_ns_ = 0;
    scene_.preparing_s = 0.0F;
    send_setup_soon();
  }
  withdraw_parts();
  const std::int64_t begin_ns = clock_.now_ns();
  ForceCommand command = step_.reply();
  is_first_reply_ = false;
  const std::int64_t end_ns = clock_.now_ns();
  const std::int64_t spent_ns = std::clamp<std::int64_t>(end_ns - arrival_ns_, 0, std::numeric_limits<std::uint32_t>::max());
  command.compute_ns = static_cast<std::uint32_t>(spent_ns);
  hub_.send(command);
  compute_times_.record(spent_ns);
  step_times_.record(end_ns - begin_ns);
  if (inside_warning_ != nullptr) note_hand();
  if (carve_sender_ != nullptr) note_carve();
}

void ReplyLoop::note_hand() noexcept {
  if (std::exchange(free_starts_, step_.free_starts()) != step_.free_starts()) {
    inside_warning_->note_start(step_.p_STouching());
  } else if (inside_warning_->is_watching()) {
    inside_warning_->note_hand(step_.p_STouching(), step_.has_contact());
  }
}

void ReplyLoop::change_method() noexcept {
  if (auto built = builder_.take()) {
    if (built->scene != nullptr && step_.grasp() != nullptr) step_.grasp()->note_built(built->scene->put_down_serial);
    if (built->scene == nullptr && is_tuned()) built->step->set_materials(tuned_->materials);
    built->step = step_.replace(std::move(built->step));
    method_text_ = built->text;
    show_method(method_text_);
    setup_.material_serial = static_cast<std::uint32_t>(step_.counts().materials_taken);
    if (built->request_id != 0) setup_.method_request = built->request_id;
    setup_.rejection = {};
    if (built->scene != nullptr) take_scene(*built->scene);
    if (patch_sender_ != nullptr) patch_sender_->set_offered(PatchSender::can_offer({setup_.method.data(), setup_.method.size()}));
    show_method_in_use();
    builder_.retire(std::move(built));
    send_setup_soon();
  } else if (const RejectedMethod* rejected = builder_.take_rejection()) {
    setup_.method_request = rejected->request_id;
    setup_.rejection = rejected->why;
    send_setup_soon();
  }
}

// The serial of the materials counts on. Changes of materials in the scene before do not apply to the objects of a new one. If an object
// was put down, the objects are the same, with their changed materials; but the hash is 0 until the new one is known (PlacedScene),
// because the old one is that of another scene.
void ReplyLoop::take_scene(const NewScene& scene) noexcept {
  scene_revision_ = scene.revision;
  if (scene.put_down_serial == 0) {
    material_revision_ = scene.revision;
    describe_scene(scene.hash, scene.facts);
    materials_.object_count = 0;
    materials_.rejection = {};
  } else {
    setup_.scene_hash = 0;
  }
  step_.set_materials(is_tuned() ? tuned_->materials : scene.materials);
  materials_.serial = static_cast<std::uint32_t>(step_.counts().materials_taken);
  // What a vision node has shown until now does not tell whether it shows the new scene.
  shown_scene_hash_ = reported_scene_hash_ = 0;
}

void ReplyLoop::describe_scene(std::uint64_t hash, const SceneFacts& facts) noexcept {
  setup_.scene_hash = hash;
  const SceneFacts before = scene_;
  scene_ = facts;
  scene_.preparing_s = before.preparing_s;
  scene_.is_hand_inside = before.is_hand_inside;
  scene_.tool_hash = before.tool_hash;
}

// A requester repeats its request until the reply comes.
void ReplyLoop::request_materials(const MaterialRequest& request) noexcept {
  if (material_task_ == nullptr || request.request == last_material_request_) return;
  last_material_request_ = request.request;
  if (step_.grasp() == nullptr || !step_.grasp()->is_busy()) return material_task_->request(request);
  materials_.request = request.request;
  put_text("the stylus holds an object, and stiffness, damping and friction cannot be changed while it is held", materials_.rejection);
  send_setup_soon();
}

void ReplyLoop::change_materials() noexcept {
  if (material_task_ == nullptr) return;
  auto result = material_task_->take();
  if (result == nullptr) return;
  if (result->scene_revision == material_revision_) {
    materials_ = result->state;
  } else {
    materials_.request = result->state.request;
    put_text("the scene was read again meanwhile; request it again", materials_.rejection);
  }
  if (result->scene_revision == material_revision_ && !result->materials.empty()) {
    if (result->tool_materials) {
      step_.set_materials(result->materials, *result->tool_materials);
      method_text_ = result->tool_method;
      show_method(method_text_);
    } else {
      step_.set_materials(result->materials);
    }
    std::swap(result, tuned_);
  }
  materials_.serial = static_cast<std::uint32_t>(step_.counts().materials_taken);
  material_task_->retire(std::move(result));
  send_setup_soon();
}

void ReplyLoop::send_patches() noexcept {
  for (int n = 0; n < kMaxPatches; ++n) {
    const Message* part = patch_sender_->front();
    if (part == nullptr) return;
    hub_.send(*part);
    patch_sender_->pop();
  }
}

void ReplyLoop::send_setup_soon() noexcept {
  setup_repeats_ = kSetupRepeats;
  next_setup_ns_ = 0;
}

void ReplyLoop::send_setup() noexcept {
  const std::int64_t now_ns = clock_.now_ns();
  const bool is_new_session = hub_.session() != setup_session_;
  if ((now_ns < next_setup_ns_ && !is_new_session) || hub_.state() != JoinState::joined) return;
  if (is_new_session) setup_repeats_ = kSetupRepeats;
  setup_session_ = hub_.session();
  setup_sent_ns_ = now_ns;
  next_setup_ns_ = now_ns + (setup_repeats_ > 0 ? kSetupRepeatNs : kSetupEveryNs);
  setup_repeats_ -= setup_repeats_ > 0 ? 1 : 0;
  setup_.method_serial = static_cast<std::uint32_t>(step_.counts().method_changes);
  setup_.view_revision = step_.view().revision;
  setup_.X_WS = step_.view().X_WS;
  hub_.send(setup_);
  if (materials_.request != 0 || materials_.serial != 0) hub_.send(materials_);
  if (scene_.given_hash != 0) hub_.send(scene_);
  send_poses();
  send_moves();
  send_shape_starts();
  if (carve_sender_ != nullptr) hub_.send(carve_sender_->announce());
}

// After the reply, and one at a time: however many requests come, the force never waits for them. The move is announced before the first
// reply that uses it.
void ReplyLoop::move_objects() {
  if (mover_ == nullptr || !mover_->has_request()) return;
  const std::int64_t now_ns = clock_.now_ns();
  if (now_ns < next_move_ns_) return;
  next_move_ns_ = now_ns + kMoveEveryNs;
  if (patch_sender_ != nullptr) mover_->set_lead_ns(patch_sender_->find_lead_ns(now_ns));
  const ObjectMover::Outcome outcome = mover_->carry_out(step_);
  if (outcome.reply.request == 0) return;  // the next one is not due yet
  if (outcome.move) hub_.send(*outcome.move);
  if (outcome.move && patch_sender_ != nullptr) patch_sender_->note_move(*outcome.move, now_ns);
  hub_.send(outcome.reply);
  if (outcome.move) {
    move_repeats_ = kSetupRepeats;
    repeat_move_ns_ = now_ns + kSetupRepeatNs;
  }
  report_move(outcome);
}

// Sends the newest move again soon, because a datagram may be lost.
void ReplyLoop::repeat_move() noexcept {
  if (move_repeats_ == 0 || clock_.now_ns() < repeat_move_ns_) return;
  --move_repeats_;
  repeat_move_ns_ += kSetupRepeatNs;
  const auto by_serial = [](const ObjectMove& a, const ObjectMove& b) { return a.serial < b.serial; };
  hub_.send(*std::max_element(mover_->moves().begin(), mover_->moves().end(), by_serial));
}

// A program that sends poses without pause is logged once.
void ReplyLoop::report_move(const ObjectMover::Outcome& outcome) {
  const std::int64_t now_ns = clock_.now_ns();
  if (outcome.reply.rejection[0] != '\0') {
    if (now_ns - move_rejected_ns_ < kNanosecondsPerSecond && move_rejected_ns_ != 0) return;
    move_rejected_ns_ = now_ns;
    log_warning("a program's request was rejected: {}", outcome.reply.rejection.data());
  } else if (outcome.move) {
    const bool is_first = last_move_ns_ == 0 || now_ns - last_move_ns_ > kNanosecondsPerSecond;
    last_move_ns_ = now_ns;
    if (is_first) log_info("a program moves {}, in {:.3g} s", mover_->name_of(outcome.reply.object), outcome.reply.over_s);
  }
}

// Sends some of the moves, in turn, for the same reasons as send_poses().
void ReplyLoop::send_moves() noexcept {
  if (mover_ == nullptr || mover_->moves().empty()) return;
  const std::span<const ObjectMove> moves = mover_->moves();
  for (std::size_t sent = 0; sent < std::min(kMaxMoveRepeats, moves.size()); ++sent) {
    hub_.send(moves[next_move_]);
    next_move_ = (next_move_ + 1) % moves.size();
  }
}

void ReplyLoop::report_scene() {
  if (shown_scene_hash_ == 0 || scene_.given_hash == 0 || shown_scene_hash_ == reported_scene_hash_) return;
  const bool was_other = reported_scene_hash_ != 0 && reported_scene_hash_ != scene_.given_hash;
  reported_scene_hash_ = shown_scene_hash_;
  if (shown_scene_hash_ != scene_.given_hash) {
    log_warning("vision_node shows another scene than the one touched here; start both with the same --scene, --unit and --no-fit");
  } else if (was_other) {
    log_info("vision_node shows the same scene again");
  }
}

void ReplyLoop::report_shown_tool() {
  if (shown_tool_hash_ == 0 || scene_.tool_hash == 0 || shown_tool_hash_ == reported_tool_hash_) return;
  const bool was_other = reported_tool_hash_ != 0 && reported_tool_hash_ != scene_.tool_hash;
  reported_tool_hash_ = shown_tool_hash_;
  if (shown_tool_hash_ != scene_.tool_hash) {
    log_warning("vision_node draws {}; start both with the same --tool, --tool-unit and --tool-grip",
                scene_.tool_hash == SceneFacts::kNoTool   ? "a rigid tool, but the stylus is a probe here"
                : shown_tool_hash_ == SceneFacts::kNoTool ? "a probe, but the stylus holds a rigid tool here"
                                                          : "another rigid tool than the one held here");
  } else if (was_other) {
    log_info("vision_node draws the same tool again");
  }
}

// Logs each change once: without a line, a tool that gives no force looks broken.
void ReplyLoop::report_tool() {
  if (step_.is_tool_blocked() == is_tool_blocked_ || !step_.is_running()) return;
  is_tool_blocked_ = !is_tool_blocked_;
  if (is_tool_blocked_) {
    log_warning("the tool overlaps the scene: no force until it is moved out");
  } else {
    log_info("the tool no longer overlaps the scene: it gives forces now");
  }
}

// For the picture of vision_node and for hapton top; the log has the warning already.
void ReplyLoop::report_inside() noexcept {
  if (inside_warning_ == nullptr || inside_warning_->is_inside() == scene_.is_hand_inside) return;
  scene_.is_hand_inside = !scene_.is_hand_inside;
  send_setup_soon();
}

std::string_view ReplyLoop::find_patch_obstacle() const noexcept {
  if (patch_sender_ == nullptr) return "";
  if (patch_sender_->is_offered()) {
    const bool is_safe = step_.grasp() == nullptr || patch_sender_->has_numbered_requests();
    return is_safe ? "" : "objects of the scene are movable, and io_node is of an older version";
  }
  if (is_holding()) return "the stylus holds a rigid tool";
  if (const std::string_view why = patch_sender_->obstacle(); !why.empty()) return why;
  if (effects_ != nullptr) return "effects from shared libraries are in use";
  const std::string_view method(setup_.method.data());
  return method.find("name=proxy") != std::string_view::npos ? "force shading is on" : "the method is not proxy";
}

// Logs each reason once, however often the round trip changes: a person must know why the hub computes no forces from parts.
void ReplyLoop::report_patches() {
  if (!wants_patches_) return;
  const std::string_view why = find_patch_obstacle();
  if (why == patch_obstacle_reported_) return;
  patch_obstacle_reported_ = why;
  if (!why.empty()) log_warning("the hub requests the scene in parts (io_node --touch), but {}: this node computes the forces", why);
  if (why.empty()) log_info("the hub receives the scene in parts again");
}

void ReplyLoop::report_hub_state() {
  const JoinState state = hub_.state();
  if (state == state_reported_) {
    if (state == JoinState::joining && !absence_reported_ && clock_.now_ns() - start_ns_ > kHubAbsentNs) {
      absence_reported_ = true;
      log_warning("no reply from a hub; start io_node, or check --hub and --key; retrying");
    }
    return;
  }
  state_reported_ = state;
  absence_reported_ = true;
  switch (state) {
    case JoinState::joined:
      log_info("joined the hub, {} samples per second", hub_.servo_rate_hz());
      break;
    case JoinState::rejected:
      log_warning("the hub already has a haptics node; waiting to take over");
      break;
    case JoinState::joining:
      if (hub_.has_hub_left()) {
        log_info("the hub has ended its session; waiting for the next one");
      } else {
        log_warning("the hub stopped replying; retrying");
      }
      break;
  }
}

}  // namespace hapton
