#include "vision_node/vision_session.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "runtime/log.h"
#include "runtime/process_age.h"
#include "vision_node/renderer_limits.h"

namespace hapton {
namespace {

constexpr std::int64_t kSceneFactsPeriodNs = 1000 * kNanosecondsPerMillisecond;    // between two messages to the hub about our scene
constexpr std::int64_t kSceneReadToleranceNs = 2000 * kNanosecondsPerMillisecond;  // tolerated between both nodes' readings of a saved file
constexpr std::int64_t kHubAbsentNs = 1000 * kNanosecondsPerMillisecond;           // time without a reply until the user is notified
// The longest wait for a message: a pressed key or an uncovered window is handled after this time at the latest. A free choice.
constexpr std::int64_t kTurnNs = 4 * kNanosecondsPerMillisecond;

}  // namespace

Result<std::unique_ptr<StereoView>> open_view(const Scene& scene, VisionOptions& options) {
  describe_scene(scene, options);
  if (const std::string_view flag = find_view_flag(options); scene.view.camera && !flag.empty()) {
    log_info("the scene's [camera] does not apply, because {} says from where it is seen", flag);
  }
  auto view = StereoView::open(options.view, list_shown_objects(scene, options.culls_open));
  if (!view) return view;
  const std::string renderer = (*view)->renderer_name();
  options.rate_limit_hz = choose_rate_limit(options, renderer);
  log_info("stereo mode {}{}, drawn by {}, {} frames a second at most", stereo_mode_name((*view)->mode()),
           options.view.stereo == StereoMode::automatic ? " (chosen by auto)" : "", renderer,
           options.rate_limit_hz > 0.0 ? fmt::format("{:g}", options.rate_limit_hz) : "any");
  return view;
}

double choose_rate_limit(const VisionOptions& options, std::string_view renderer_name) {
  if (options.rate_limit_hz >= 0.0) return options.rate_limit_hz;
  return is_software_renderer(renderer_name) ? 30.0 : 60.0;
}

VisionSession::VisionSession(StereoView& view, HubClient& hub, Clock& clock, const VisionOptions& options)
    : view_(view),
      hub_(hub),
      clock_(clock),
      options_(options),
      window_(view, clock, options),
      step_(window_.step()),
      screenshot_moment_(options.screenshot_moment) {}

Result<void> VisionSession::run(const StopSignal& stop) {
  Result<void> shown = show_until_end(stop);
  // Even if the loop ended with an error: a person's strokes and measures must not be lost.
  const Result<void> saved = annotator_ != nullptr ? annotator_->finish() : Result<void>{};
  if (shown) shown = take_last_screenshot();
  if (!shown && !saved) log_error("{}", saved.error().what);
  return shown ? saved : shown;
}

Result<void> VisionSession::show_until_end(const StopSignal& stop) {
  start_ns_ = clock_.now_ns();
  const std::int64_t end_ns = options_.seconds > 0.0 ? start_ns_ + static_cast<std::int64_t>(options_.seconds * 1e9) : INT64_MAX;
  // Before the hub is joined, so that work that takes long only the first time does not delay a probe.
  if (auto drawn = draw_if_wanted(); !drawn) return drawn;
  view_.prepare_shaders();
  while (!quit_ && !stop.stop_requested() && clock_.now_ns() < end_ns) {
    // With a headset, begin_headset_turn() waits for the time of the next frame.
    is_for_headset_ = begin_headset_turn();
    receive_from_hub(is_for_headset_ ? 0 : std::min(clock_.now_ns() + kTurnNs, end_ns));
    follow_scene();
    attend_window();
    // Before drawing, while the received states are fresh: a slow frame then neither makes a message look lost nor delays one.
    send_pending();
    if (other_hand_ != nullptr) other_hand_->update(step_.scene_pose(), clock_.now_ns());
    if (auto drawn = draw_if_wanted(); !drawn) return drawn;
    window_.refine_scene();
    lead_hand();
  }
  return {};
}

Result<void> VisionSession::take_last_screenshot() {
  if (options_.screenshot.empty() || screenshot_moment_.taken()) return {};
  draw();  // so that the screenshot shows what has changed since the last frame
  if (auto taken = window_.take_screenshot(options_.screenshot); !taken) return taken;
  if (screenshot_moment_.missed_contact()) {
    log_info("{} shows no contact: {} before the end", options_.screenshot.string(),
             hub_.counts().joins == 0 ? "no hub replied" : "none was drawn for 0.3 s");
  }
  return {};
}

// True: the headset waits for a frame.
bool VisionSession::begin_headset_turn() {
  if (headset_ == nullptr) return false;
  const StereoMode before = view_.mode();
  const bool is_wanted = headset_->begin_turn(options_.view.framing);
  if (view_.mode() != before) step_.set_stereo(stereo_mode_name(view_.mode()), false);
  quit_ = quit_ || headset_->has_ended();
  return is_wanted;
}

// Waits for one message, then takes all that have come: the newest state wins.
void VisionSession::take_states(std::int64_t deadline_ns) {
  Datagram received;
  for (bool more = hub_.receive(received, deadline_ns); more; more = hub_.receive(received, 0)) {
    note_join();
    if (const auto* rejected = std::get_if<ViewRejected>(&received.message)) step_.receive(*rejected);
    if (const auto* view = std::get_if<ViewTransform>(&received.message); view != nullptr && hub_.last_arrival() == Arrival::newest) {
      step_.receive(*view);
    }
    if (const auto* setup = std::get_if<HapticsSetup>(&received.message)) window_.use_setup(*setup);
    if (const auto* reply = std::get_if<MarkerReply>(&received.message)) {
      if (const auto line = marker_key_.accept(*reply)) log_info("{}", *line);
    }
    if (const auto* scene = std::get_if<SceneFacts>(&received.message); scene != nullptr && hub_.last_arrival() == Arrival::newest) {
      take_scene(*scene);
    }
    if (const auto* pose = std::get_if<ObjectPose>(&received.message)) take_pose(*pose);
    if (const auto* move = std::get_if<ObjectMove>(&received.message); move != nullptr && moved_ != nullptr) {
      moved_->take(*move, hub_.last_arrival());
    }
    if (const auto* part = std::get_if<ObjectShape>(&received.message); part != nullptr && moved_ != nullptr) {
      moved_->take(*part, hub_.last_arrival());
    }
    if (const auto* start = std::get_if<ShapeStart>(&received.message); start != nullptr && moved_ != nullptr) {
      moved_->take(*start, hub_.last_arrival());
    }
    if (const auto* carves = std::get_if<Carves>(&received.message); carves != nullptr && carved_ != nullptr) {
      carved_->take(*carves, hub_.last_arrival());
    }
    const auto* state = std::get_if<ProbeState>(&received.message);
    if (state != nullptr && hub_.last_arrival() == Arrival::newest) take_state(*state);
  }
}

// A picture shows only the newest state; a stroke gets a point from each state.
void VisionSession::take_state(const ProbeState& state) {
  received_ns_ = hub_.receive_time_ns();
  step_.receive(state, received_ns_);
  if (moved_ != nullptr && moved_->has_motion()) {
    if (moved_->set_time(state.scene_time_ns)) step_.request_redraw();
    if (annotator_ != nullptr) annotator_->place_moving(moved_->moving());
  }
  if (annotator_ != nullptr) annotator_->receive(state, step_.find_scene_pose(state.view_revision));
}

void VisionSession::take_pose(const ObjectPose& pose) {
  if (moved_ == nullptr || moved_->is_overtaken(pose, hub_.last_arrival())) return;
  if (moved_->take(pose)) step_.set_held_object(moved_->held());
  if (annotator_ != nullptr) annotator_->receive(pose);
}

void VisionSession::annotate(const UserRequests& requests) {
  if (annotator_ == nullptr) return;
  annotator_->handle(requests, view_.screen(), step_.workspace_centre());
  if (std::exchange(shown_annotations_revision_, annotator_->revision()) == annotator_->revision()) return;
  step_.set_annotations(annotator_->describe());
}

// newest: a new notice; empty: there is none.
void VisionSession::show_notice(std::string newest) {
  if (notice_.update(std::move(newest), clock_.now_ns())) step_.set_recent_event(notice_.line());
}

// Call it before the messages of a newly joined hub are handled.
void VisionSession::note_join() {
  if (hub_.state() != JoinState::joined || (was_joined_ && hub_.counts().joins == joins_)) return;
  log_info("joined the hub, servo rate {:.0f} Hz", hub_.servo_rate_hz());
  step_.note_join();
  next_scene_facts_ns_ = 0;
  joins_ = hub_.counts().joins;
  was_joined_ = true;
}

void VisionSession::receive_from_hub(std::int64_t deadline_ns) {
  take_states(deadline_ns);
  note_join();
  const bool joined = hub_.state() == JoinState::joined;
  if (!joined && was_joined_) {
    if (hub_.has_hub_left()) {
      log_info("the hub has ended its session; waiting for the next one");
    } else {
      log_warning("the hub stopped replying; retrying");
    }
    step_.note_loss();
  } else if (!joined && !is_absence_reported_ && hub_.counts().joins == 0 && clock_.now_ns() - start_ns_ > kHubAbsentNs) {
    log_warning("no hub replies; start io_node, or check --hub and --key; retrying");
    is_absence_reported_ = true;
  }
  was_joined_ = joined;
}

void VisionSession::take_scene(const SceneFacts& haptic_scene) {
  step_.set_preparing(haptic_scene.preparing_s, clock_.now_ns());
  haptic_hash_ = haptic_scene.given_hash;
  if (live_scene_ != nullptr) live_scene_->set_felt(haptic_hash_);
  compare_scene();
  compare_tool(haptic_scene.tool_hash);
}

void VisionSession::compare_tool(std::uint64_t held_hash) {
  const bool is_other = held_hash != 0 && held_hash != tool_hash_;
  if (is_other == is_other_tool_) return;
  is_other_tool_ = is_other;
  step_.set_other_tool(is_other);
  if (is_other) {
    log_warning("haptics_node {}; start both with the same --tool, --tool-unit and --tool-grip",
                held_hash == SceneFacts::kNoTool    ? "touches with a probe, but a rigid tool is drawn"
                : tool_hash_ == SceneFacts::kNoTool ? "holds a rigid tool, but a probe is drawn"
                                                    : "holds another rigid tool than the one drawn");
  } else {
    log_info("haptics_node now holds the tool that is drawn");
  }
}

void VisionSession::set_live_scene(LiveScene* scene) {
  live_scene_ = scene;
  scene_hash_ = scene->scene().given_hash;
  moved_ = &scene->moved();
  carved_ = &scene->carved();
  window_.set_teacher(&scene->teacher());
}

// Pre: no frame is being drawn, because this may replace the objects that a frame draws.
void VisionSession::follow_scene() {
  if (live_scene_ == nullptr) return;
  if (const auto change = live_scene_->follow(clock_.now_ns())) {
    set_live_scene(live_scene_);
    if (annotator_ != nullptr) annotator_->change_scene(live_scene_->scene(), carved_, moved_);
    window_.change_scene(&live_scene_->teacher(), change->has_new_camera);
    step_.set_held_object(moved_->held());
    next_scene_facts_ns_ = 0;
  }
  step_.set_scene_problem(live_scene_->problem());
  compare_scene();
}

// If the file is watched, haptics_node may read it before this node: another scene then counts only kSceneReadToleranceNs after this node's
// reading.
void VisionSession::compare_scene() {
  if (scene_hash_ == 0 || haptic_hash_ == 0) return;
  bool is_other = haptic_hash_ != scene_hash_;
  if (!is_other) other_scene_since_ns_ = 0;
  const bool is_reading = live_scene_ != nullptr && live_scene_->is_reading();
  if (is_other && (other_scene_since_ns_ == 0 || is_reading)) other_scene_since_ns_ = clock_.now_ns();
  if (is_other && live_scene_ != nullptr && live_scene_->is_watched())
    is_other = clock_.now_ns() - other_scene_since_ns_ >= kSceneReadToleranceNs;
  if (is_other == is_other_scene_) return;
  is_other_scene_ = is_other;
  step_.set_other_scene(is_other);
  if (annotator_ != nullptr) annotator_->set_other_scene(is_other);
  if (is_other) {
    log_warning("haptics_node has another scene than the one shown; start both with the same --scene, --unit and --no-fit");
  } else {
    log_info("haptics_node now has the scene that is shown");
  }
}

void VisionSession::attend_window() {
  if (knobs_ != nullptr) step_.turn_dials(knobs_->take_turn_degrees(clock_.now_ns()));
  if (carved_ != nullptr && carved_->show()) step_.reshape_scene();
  const UserRequests requests = window_.poll_events({}, [this](const WindowEvent& event) { return find_surface(event); });
  quit_ = quit_ || requests.quit;
  if (requests.mark) marker_key_.press(clock_.now_ns());
  annotate(requests);
  show_notice(annotator_ != nullptr ? annotator_->take_notice() : std::string());
  if (view_.mode() == StereoMode::openxr) move_in_headset(requests);
  if (!requests.screenshot) return;
  draw();
  show_notice(window_.take_numbered_screenshot());
}

// A person wears the headset, so requests to move the head move the workspace instead.
void VisionSession::move_in_headset(const UserRequests& requests) {
  if (requests.reset_head) headset_->recentre();
  headset_->move_viewer(requests.head_motion_m);
}

// The point under the pointer: on the menu if that is nearer to the viewer, otherwise on the scene.
std::optional<Vec3> VisionSession::find_surface(const WindowEvent& event) {
  const std::optional<Vec3> scene = view_.pick(event.x_px, event.y_px);
  if (annotator_ == nullptr) return scene;
  const StereoScreen screen = view_.screen();
  const std::optional<Vec3> menu = annotator_->find_menu_point(screen, view_.picture_size(), event.x_px, event.y_px);
  const auto height = [&](const Vec3& p_W) { return (screen.X_WV.inverse(Eigen::Isometry) * p_W).z(); };
  return menu && (!scene || height(*menu) > height(*scene)) ? menu : scene;
}

// Moves the hand towards the pointer's position.
void VisionSession::lead_hand() {
  if (step_.interaction().is_hand_led()) step_.lead_hand(view_.visible_depth().get());
}

void VisionSession::send_pending() {
  if (hub_.state() != JoinState::joined) return;
  if (scene_hash_ != 0 && clock_.now_ns() >= next_scene_facts_ns_) {
    next_scene_facts_ns_ = clock_.now_ns() + kSceneFactsPeriodNs;
    hub_.send(SceneFacts{.given_hash = scene_hash_, .tool_hash = tool_hash_});
  }
  while (const auto message = step_.take_message(clock_.now_ns())) hub_.send(*message);
  if (moved_ != nullptr) {
    if (const auto request = moved_->take_shape_request(clock_.now_ns())) hub_.send(*request);
  }
  if (carved_ != nullptr) {
    if (const auto request = carved_->take_request(clock_.now_ns())) hub_.send(*request);
  }
  if (annotator_ != nullptr) {
    if (const auto pose = annotator_->take_due(clock_.now_ns())) hub_.send(*pose);
    if (const auto undo = annotator_->take_carve_undo(clock_.now_ns())) hub_.send(*undo);
  }
  while (const auto marker = marker_key_.take_due(clock_.now_ns())) hub_.send(*marker);
}

Result<void> VisionSession::draw_if_wanted() {
  const std::int64_t begin_ns = clock_.now_ns();
  const bool other_wants = other_wants_picture(begin_ns);
  const bool is_wanted = is_for_headset_ || step_.wants_picture(begin_ns, window_.where());
  if (!is_wanted) {
    if (const auto ack = step_.take_unchanged_ack()) {
      (void)acks_.note(received_ns_, begin_ns);
      hub_.send(*ack);
    }
    if (!other_wants) return {};
  }
  draw();
  const bool keep = !options_.screenshot.empty() && screenshot_moment_.take_now(begin_ns - start_ns_, step_.contact());
  return keep ? window_.take_screenshot(options_.screenshot) : Result<void>{};
}

void VisionSession::draw() {
  const std::int64_t begin_ns = clock_.now_ns();
  const VisionStep::Shown shown = step_.compose(begin_ns);
  window_.show(shown);
  if (other_hand_ != nullptr && other_hand_->shown()) view_.set_other_probe(*other_hand_->shown());
  // The probe moves on while the scene is drawn, so its newest sample is drawn. But if objects move, scene and probe are drawn from one
  // sample: the probe must not leave a surface that carries it.
  const bool is_moving = moved_ != nullptr && moved_->has_motion();
  if (is_moving) moved_->place_moving();
  view_.draw([this, &shown, is_moving] {
    if (!is_moving) take_states(0);
    if (annotator_ != nullptr) annotator_->show(shown.X_WS);
    if (const auto newest = step_.newest_probe()) view_.set_probe(*newest);
  });
  if (std::exchange(is_for_headset_, false)) headset_->show();
  report_frame(begin_ns, clock_.now_ns());
  if (step_.frames().drawn() == 1) {
    if (const auto age_s = read_process_age_s()) log_info("first frame {:.2f} s after the start", *age_s);
  }
}

bool VisionSession::other_wants_picture(std::int64_t now_ns) {
  if (other_hand_ == nullptr || !step_.may_draw(now_ns)) return false;
  const VisionStep::Screen at = window_.where();
  return other_hand_->wants_picture(at.sizes, at.screen, at.picture);
}

// Acknowledges the newest probe state: the frame shows it even if it came while the scene was drawn.
void VisionSession::report_frame(std::int64_t begin_ns, std::int64_t end_ns) {
  const VisionStep::Screen at = window_.where();
  if (const auto ack = step_.end_frame(begin_ns, end_ns, at)) acknowledge(*ack, end_ns);
  if (other_hand_ != nullptr) other_hand_->end_frame(begin_ns, end_ns, step_.frames().recent_rate_hz(), at.sizes, at.screen, at.picture);
}

// Only the first frame with a state tells how old it is when shown; later ones (the scene was turned, the other hand moved) do not.
void VisionSession::acknowledge(FrameAck ack, std::int64_t end_ns) {
  const StateAcks::Kind kind = acks_.note(received_ns_, end_ns);
  if (kind == StateAcks::Kind::none) return;
  ack.unchanged = kind == StateAcks::Kind::repeat;
  if (kind == StateAcks::Kind::first) {
    step_.record_motion(end_ns - received_ns_, end_ns);
    ack.held_ns = static_cast<std::uint32_t>(std::clamp<std::int64_t>(end_ns - received_ns_, 1, std::numeric_limits<std::uint32_t>::max()));
  }
  hub_.send(ack);
}

namespace {

// A simulated probe that moves on a circle, with a new sample every millisecond.
class BenchProbe {
 public:
  explicit BenchProbe(double radius_m) : radius_m_(radius_m) {}

  // The newest sample at now_ns.
  ProbeShown newest(std::int64_t now_ns) {
    sample_ns_ = now_ns / kNanosecondsPerMillisecond * kNanosecondsPerMillisecond;
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(sample_ns_ % kRoundNs) / static_cast<double>(kRoundNs);
    ProbeShown probe;
    probe.p_WP = probe.p_WD = radius_m_ * Vec3(std::cos(angle), std::sin(angle), 1.0);
    return probe;
  }
  std::int64_t sample_ns() const { return sample_ns_; }

 private:
  // Time for one turn of the simulated probe; a free choice.
  static constexpr std::int64_t kRoundNs = 1000 * kNanosecondsPerMillisecond;
  double radius_m_;
  std::int64_t sample_ns_ = 0;
};

// A force that goes up and down, for plots.
ProbeState bench_state(std::int64_t now_ns) {
  ProbeState state;
  state.force_n = Vec3(0.0, 4.0 + 3.0 * std::sin(3e-9 * static_cast<double>(now_ns % 1'000'000'000'000)), 0.0);
  state.force_limit_n = 8.5F;
  return state;
}

}  // namespace

std::string run_bench(StereoView& view, Clock& clock, int frames, bool with_plots) {
  const std::int64_t first_ns = clock.now_ns();
  view.draw();  // the first frame builds shaders
  const double first_ms = static_cast<double>(clock.now_ns() - first_ns) * 1e-6;
  Dials dials;
  FrameLog log;
  LivePlots plots(with_plots);
  const auto turn_and_draw = [&](FrameLog& into, const std::function<void()>& before_probe) {
    const std::int64_t start_ns = clock.now_ns();
    dials.turn(1, 3.0);
    dials.turn(0, 1.0);
    view.set_scene_pose(dials.compute_pose(Vec3::Zero()));
    view.poll_events();
    view.set_plots(plots.update(start_ns));
    view.draw(before_probe);
    into.record_frame(start_ns, clock.now_ns());
    plots.receive(bench_state(start_ns), start_ns);
    plots.record_motion_to_photon(clock.now_ns() - start_ns, start_ns);
  };
  BenchProbe probe(0.25 * std::min(view.screen().width_m, view.screen().height_m));
  const auto turn_with_probe = [&](FrameLog& into) {
    turn_and_draw(into, [&] { view.set_probe(probe.newest(clock.now_ns())); });
    into.record_motion_to_photon(clock.now_ns() - probe.sample_ns());
  };
  FrameLog unprepared;  // while the levels of detail are made, which happens once
  while (view.detail_progress() < 1.0) turn_with_probe(unprepared);
  for (int i = 0; i < frames; ++i) turn_and_draw(log, {});
  FrameLog moving;  // frames with a moving probe, which takes time to draw
  for (int i = 0; i < frames; ++i) turn_with_probe(moving);
  const PictureSize size = view.picture_size();
  const std::string before = unprepared.draw_time().count() == 0 ? std::string()
                                                                 : fmt::format(", {:.1f} Hz while its levels of detail were made, {}",
                                                                               unprepared.rate_hz(), unprepared.describe_motion());
  return fmt::format(
      "bench: {} frames, {:.1f} Hz, {}, {}x{} an eye, drawing p50 {:.1f} ms p99 {:.1f} ms, first frame {:.0f} ms, {}{}, {} triangles "
      "an eye, {}",
      frames, log.rate_hz(), stereo_mode_name(view.mode()), size.width_px, size.height_px, log.draw_time().quantile_ns(0.5) * 1e-6,
      log.draw_time().quantile_ns(0.99) * 1e-6, first_ms, moving.describe_motion(), before, view.paint_count().triangles,
      view.renderer_name());
}

}  // namespace hapton
