#include "vision_node/vision_step.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/base/period_ns.h"
#include "core/math/rigid_pose.h"
#include "vision_node/hud_text.h"

namespace hapton {
namespace {

// Numbers that change faster cannot be read, and must not cause frames.
constexpr std::int64_t kHudPeriodNs = 400'000'000;
// A frame that is drawn anyway shows newer numbers, at a rate that can still be read.
constexpr std::int64_t kHudRefreshNs = 100'000'000;

// How long to wait for the hub's view, which the hub repeats four times a second.
constexpr std::int64_t kViewWaitNs = 600'000'000;

// haptics_node repeats every 200 ms that it prepares its scene; one that is silent for this long has ended.
constexpr std::int64_t kPreparingLifetimeNs = 3'000'000'000;

// A scene that has not been turned for this long is at rest.
constexpr std::int64_t kRestNs = 150'000'000;

}  // namespace

VisionStep::VisionStep(VisionStepSettings settings)
    : settings_(std::move(settings)),
      watch_(settings_.threshold_px),
      culls_(settings_.cull),
      shows_help_(settings_.help),
      shows_depth_cues_(settings_.depth_cues),
      plots_(settings_.plots),
      head_(settings_.head, settings_.ipd_m),
      head_shown_(settings_.head) {
  interaction_.dials() = settings_.dials;
  sender_.set(settings_.dials.compute_pose(settings_.p_WC));
}

void VisionStep::receive(const ProbeState& state, std::int64_t received_ns) {
  state_ = state;
  plots_.receive(state, received_ns);
  is_connected_ = true;
  has_new_state_ = true;
  knows_view_ |= !has_state_since_joining_ && state.view_revision == 0;  // 0: the hub has no view
  has_state_since_joining_ = true;
  sender_.confirm(state.view_revision);
}

void VisionStep::receive(const ViewTransform& view) {
  const auto X_WS = find_rigid_pose(view.X_WS);
  if (keeps_own_dials() || !X_WS) return;
  knows_view_ = true;
  if (!sender_.adopt(view, !has_sent_view_)) return;
  const std::optional<Dials> dials = find_dials(*X_WS, settings_.p_WC);
  home_WS_ = dials ? Pose(Pose::Identity()) : *X_WS;
  interaction_.dials() = dials.value_or(Dials{});
}

void VisionStep::note_join() {
  is_connected_ = true;
  has_state_since_joining_ = knows_view_ = has_sent_view_ = false;
  waits_until_ns_.reset();
  sender_.rejoin();
}

bool VisionStep::wants_surface(const WindowEvent& event) const {
  if (event.kind == WindowEvent::Kind::press) return event.button == WindowEvent::Button::left;
  return event.kind == WindowEvent::Kind::move && interaction_.is_hand_led();
}

void VisionStep::handle(const WindowEvent& event, const Screen& where, const std::optional<Vec3>& p_WQ) {
  Interaction::View view{where.screen, where.picture, settings_.p_WC, p_WQ};
  if (state_ && state_->p_WD.allFinite()) view.p_WD = state_->p_WD;
  const Dials before = interaction_.dials();
  interaction_.handle(event, view);
  send_dials(before);
}

// Sends nothing if the dials have not changed: an adopted pose equals the pose that they give only to a float's precision.
void VisionStep::send_dials(const Dials& before) {
  if (interaction_.dials() != before) sender_.set(dialled_pose());
}

void VisionStep::lead_hand(const VisibleDepth* visible) {
  if (visible == nullptr || !state_) return;
  const LedTip tip{state_->p_WD + state_->visual_offset_m, state_->contact ? state_->visual_offset_m : Vec3(Vec3::Zero())};
  if (tip.p_WP.allFinite()) interaction_.follow(*visible, tip);
}

void VisionStep::turn_dials(const Vec3& degrees) {
  if (degrees.isZero()) return;
  const Dials before = interaction_.dials();
  for (int axis = 0; axis < 3; ++axis) interaction_.dials().turn(axis, degrees[axis]);
  send_dials(before);
}

UserRequests VisionStep::take_requests() {
  const UserRequests requests = interaction_.take_requests();
  culls_ = culls_ != requests.toggle_cull;
  shows_help_ = shows_help_ != requests.toggle_help;
  shows_depth_cues_ = shows_depth_cues_ != requests.toggle_depth_cues;
  if (requests.toggle_plots) plots_.toggle();
  needs_redraw_ = needs_redraw_ || requests.toggle_cull || requests.toggle_help || requests.toggle_depth_cues || requests.toggle_plots;
  if (requests.reset_head) head_.reset();
  head_.move(requests.head_motion_m);
  if (requests.look_at_scene) interaction_.camera().look_at(settings_.home, scene_pose() * settings_.p_SO, settings_.scene_radius_m);
  return requests;
}

void VisionStep::change_scene(const Framing& home, const Vec3& p_SO, double radius_m, std::vector<ObjectName> names, bool is_view_new) {
  settings_.home = home;
  settings_.p_SO = p_SO;
  settings_.scene_radius_m = radius_m;
  settings_.names = std::move(names);
  if (is_view_new) interaction_.camera() = {};
  hud_shown_.clear();
  reshape_scene();
}

void VisionStep::set_stereo(std::string_view name, bool always_changing) {
  settings_.stereo = name;
  settings_.always_changing = always_changing;
  needs_redraw_ = true;
}

std::optional<ProbeShown> VisionStep::newest_probe() const { return state_ ? std::optional(probe_shown()) : std::nullopt; }

bool VisionStep::is_scene_at_rest(std::int64_t now_ns) const {
  return frames_.drawn() > 0 && !needs_redraw_ && scene_pose().matrix() == X_WS_shown_.matrix() && interaction_.camera() == camera_shown_ &&
         is_head_at_rest_ && now_ns - scene_moved_ns_ >= kRestNs;
}

// Joining must not turn the scene: the view that the hub has comes first. If the hub's first state says that there is a view, this node
// waits for it: its datagram may have been lost, or the hub may first have to get it from the haptics node.
bool VisionStep::may_send_view(std::int64_t now_ns) {
  if (!has_state_since_joining_) return false;
  if (knows_view_ || has_sent_view_ || keeps_own_dials()) return true;
  if (!waits_until_ns_) waits_until_ns_ = now_ns + kViewWaitNs;
  return now_ns >= *waits_until_ns_;
}

std::optional<Message> VisionStep::take_message(std::int64_t now_ns) {
  if (may_send_view(now_ns)) {
    if (const auto view = sender_.take_due(now_ns)) {
      has_sent_view_ = true;
      return *view;
    }
  }
  if (const auto hand = interaction_.take_hand(now_ns)) return *hand;
  return std::nullopt;
}

HudFacts VisionStep::hud_facts(std::int64_t now_ns) const {
  HudFacts facts;
  facts.is_connected = is_connected_ && state_;
  if (state_) facts.state = *state_;
  facts.frame_rate_hz = frames_.recent_rate_hz();
  facts.dials_degrees = interaction_.dials().degrees;
  facts.stereo = settings_.stereo;
  facts.cull = culls_;
  facts.is_hand_led = interaction_.is_hand_led();
  facts.detail_progress = detail_progress_;
  if (now_ns - preparing_set_ns_ < kPreparingLifetimeNs) facts.preparing_s = preparing_s_;
  facts.is_other_scene = is_other_scene_;
  facts.is_other_tool = is_other_tool_;
  // The numbers of another scene's objects mean nothing here.
  if (!is_other_scene_) {
    facts.touched_name = describe_object(settings_.names, touched_object());
    facts.held_name = describe_object(settings_.names, held_object_);
  }
  facts.annotations = annotations_;
  facts.recording = recording_;
  facts.recent_event = recent_event_;
  facts.teaching = teaching_;
  facts.head = describe_head(head_.head(), settings_.head);
  facts.head_notice = head_notice_;
  facts.scene_problem = scene_problem_;
  facts.scene_diameter_m = 2.0 * settings_.scene_radius_m;
  facts.scene_distance_m = (scene_pose() * settings_.p_SO - settings_.p_WC).norm();
  return facts;
}

bool VisionStep::may_draw(std::int64_t now_ns) const {
  return settings_.max_rate_hz <= 0.0 || frames_.drawn() == 0 ||
         static_cast<double>(now_ns - last_start_ns_) >= 1e9 / settings_.max_rate_hz;
}

// A point behind the screen, or in front of it by at most half its distance from the eyes, moves in the picture no farther than an eye.
bool VisionStep::has_head_moved(const Screen& where) const {
  const double moved_m = compute_eye_motion_m(head_shown_, head_.head(), settings_.ipd_m);
  const double pixels_per_m = compute_viewer_scale(settings_.home, where.screen.width_m) / where.screen.width_m * where.picture.width_px;
  return moved_m * pixels_per_m > settings_.threshold_px;
}

bool VisionStep::wants_picture(std::int64_t now_ns, const Screen& where) {
  is_head_at_rest_ = !has_head_moved(where);
  if (!may_draw(now_ns)) return false;
  if (needs_redraw_ || !is_head_at_rest_ || has_new_annotations_ || settings_.always_changing ||
      scene_pose().matrix() != X_WS_shown_.matrix() || interaction_.camera() != camera_shown_)
    return true;
  if (std::exchange(has_new_state_, false)) {
    if (watch_.differs(probe_shown(), where.sizes, where.screen, where.picture)) return true;
    frames_.count_skipped();
    has_unseen_state_ = true;
  }
  if (!recorded_X_WS_ && plots_.wants_picture(now_ns)) return true;
  return now_ns - hud_ns_ >= kHudPeriodNs && compose_hud(hud_facts(now_ns)) != hud_shown_;
}

std::string_view VisionStep::help() const {
  if (!shows_help_) return {};
  return recorded_X_WS_ ? recording_keys_help() : keys_help();
}

VisionStep::Texts VisionStep::compose_texts(std::int64_t now_ns) {
  const HudFacts facts = hud_facts(now_ns);
  hud_shown_ = compose_hud(facts);
  notice_shown_ = compose_notice(facts);
  hud_contact_ = contact();
  hud_object_ = touched_object();
  hud_ns_ = now_ns;
  return {hud_shown_, help(), notice_shown_};
}

VisionStep::Shown VisionStep::compose(std::int64_t now_ns) {
  Shown shown;
  shown.X_WS = scene_pose();
  shown.framing = interaction_.camera().apply(settings_.home);
  if (!is_head_at_rest_) head_shown_ = head_.head();  // a smaller motion is invisible, but would redraw the whole scene
  shown.framing.head = head_shown_;
  shown.probe = newest_probe();
  if (now_ns - hud_ns_ >= kHudRefreshNs || hud_shown_.empty() || needs_redraw_ || contact() != hud_contact_ ||
      touched_object() != hud_object_) {
    compose_texts(now_ns);
  }
  shown.hud = hud_shown_;
  shown.notice = notice_shown_;
  shown.help = help();
  shown.cull = culls_;
  shown.depth_cues = shows_depth_cues_;
  shown.plots = plots_.update(now_ns);
  needs_redraw_ = has_new_annotations_ = false;
  return shown;
}

std::optional<FrameAck> VisionStep::end_frame(std::int64_t start_ns, std::int64_t end_ns, const Screen& where) {
  last_start_ns_ = start_ns;
  frames_.record_frame(start_ns, end_ns);
  if (std::exchange(has_new_shape_, false) || scene_pose().matrix() != X_WS_shown_.matrix() || interaction_.camera() != camera_shown_ ||
      !is_head_at_rest_) {
    scene_moved_ns_ = start_ns;
    is_head_at_rest_ = true;
  }
  X_WS_shown_ = scene_pose();
  camera_shown_ = interaction_.camera();
  has_new_state_ = has_unseen_state_ = false;
  if (!state_) return std::nullopt;
  watch_.note_drawn(probe_shown(), where.sizes, where.screen, where.picture);
  FrameAck ack{state_->sample, state_->sample_time_ns, static_cast<float>(frames_.recent_rate_hz())};
  if (settings_.max_rate_hz > 0.0) {
    ack.rest_ns = static_cast<std::uint32_t>(
        std::clamp<std::int64_t>(start_ns + period_ns(settings_.max_rate_hz) - end_ns, 0, std::numeric_limits<std::uint32_t>::max()));
  }
  return ack;
}

std::optional<FrameAck> VisionStep::take_unchanged_ack() {
  if (!std::exchange(has_unseen_state_, false)) return std::nullopt;
  FrameAck ack{state_->sample, state_->sample_time_ns, static_cast<float>(frames_.recent_rate_hz())};
  ack.unchanged = true;
  return ack;
}

}  // namespace hapton
