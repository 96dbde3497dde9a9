#include "vision_node/recorded_session.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "runtime/log.h"
#include "runtime/process_age.h"
#include "runtime/standard_streams.h"
#include "vision_node/frame_folder.h"
#include "vision_node/recorded_state.h"

namespace hapton {
namespace {

constexpr std::int64_t kRecordedTurnNs = 4 * kNanosecondsPerMillisecond;  // a turn of the loop: well below a frame of 60 Hz
// While it plays, the time shown in the HUD is redrawn this often even if nothing else moves.
constexpr std::int64_t kRecordedClockNs = 100 * kNanosecondsPerMillisecond;

}  // namespace

RecordedSession::RecordedSession(StereoView& view, Clock& clock, const VisionOptions& options, const RecordingIndex& index,
                                 RecordingRows& rows)
    : view_(view),
      clock_(clock),
      options_(options),
      index_(index),
      rows_(rows),
      player_(index.begin_s(), index.end_s()),
      control_(index, rows, player_),
      window_(view, clock, options),
      time_line_(make_time_line(index)),
      export_(options.annotations.export_folder),
      screenshot_moment_(options.screenshot_moment) {
  player_.set_speed(options.speed);
  if (!options.at_s) return;
  player_.seek(*options.at_s);
  player_.pause();
}

void RecordedSession::set_moved_objects(MovedObjects* moved, RecordingShapes* shapes) {
  moved_ = moved;
  objects_.emplace(index_, *moved);
  if (shapes != nullptr) surfaces_.emplace(index_, *shapes, *moved);
}

void RecordedSession::set_carved_objects(CarvedObjects* carved) {
  carved_ = carved;
  carves_.emplace(index_, *carved);
}

void RecordedSession::set_marks(const Scene& scene, RecordedMarks* marks) {
  scene_ = &scene;
  marks_ = marks;
}

Result<void> RecordedSession::run(const StopSignal& stop) {
  start_ns_ = clock_.now_ns();
  const std::int64_t end_ns = options_.seconds > 0.0 ? start_ns_ + static_cast<std::int64_t>(options_.seconds * 1e9) : INT64_MAX;
  if (auto shown = show_moment(); !shown) return shown;
  if (auto drawn = draw_if_wanted(); !drawn) return drawn;
  if (options_.at_s && !options_.screenshot.empty()) return take_moment_screenshot(stop);
  if (!options_.frames.empty()) return write_frames(stop);
  view_.prepare_shaders();
  window_.step().request_redraw();  // draw again: prepare_shaders() hides the probe
  while (!quit_ && !stop.stop_requested() && clock_.now_ns() < end_ns) {
    clock_.sleep_until_ns(std::min(clock_.now_ns() + kRecordedTurnNs, end_ns));
    std::string notice = attend_window();
    const bool has_control_changed = control_.take_changed();
    if (has_control_changed) window_.step().request_redraw();
    const bool has_new_notice = show_notice(std::move(notice));
    if (player_.advance(clock_.now_ns()) || has_control_changed || has_new_notice) {
      if (auto shown = show_moment(); !shown) return shown;
    }
    if (auto drawn = draw_if_wanted(); !drawn) return drawn;
    window_.refine_scene();
  }
  if (options_.screenshot.empty() || screenshot_moment_.taken()) return {};
  draw();  // so that the screenshot also has what has changed since the last frame
  return window_.take_screenshot(options_.screenshot);
}

// Takes the screenshot of --at.
Result<void> RecordedSession::take_moment_screenshot(const StopSignal& stop) {
  const auto completed = complete_moment(stop);
  if (!completed) return tl::unexpected(completed.error());
  return *completed ? window_.take_screenshot(options_.screenshot) : Result<void>();
}

// Draws the moment, after waiting for the teaching view and for carved objects, which other threads compute. False: a stop was requested
// before, and nothing was drawn.
Result<bool> RecordedSession::complete_moment(const StopSignal& stop) {
  constexpr std::int64_t kPauseNs = 5 * kNanosecondsPerMillisecond;  // between two checks of the other threads; a free choice
  window_.finish_teaching(stop);
  while (!stop.stop_requested() && carved_ != nullptr && !carved_->is_up_to_date()) {
    show_carved();
    clock_.sleep_until_ns(clock_.now_ns() + kPauseNs);
  }
  if (stop.stop_requested()) return false;
  if (auto shown = show_moment(); !shown) return tl::unexpected(shown.error());
  window_.step().request_redraw();  // so that the texts in the picture are those of this moment
  draw();
  return true;
}

// Writes the pictures of a video one after the other: each shows its own moment, however long it takes to draw.
Result<void> RecordedSession::write_frames(const StopSignal& stop) {
  auto folder = FrameFolder::open(options_.frames);
  if (!folder) return tl::unexpected(folder.error());
  const double begin_s = player_.moment_s();
  const double end_s = options_.seconds > 0.0 ? std::min(begin_s + options_.seconds, index_.end_s()) : index_.end_s();
  player_.pause();
  for (std::uint64_t n = 0; !stop.stop_requested(); ++n) {
    const double t_s = begin_s + static_cast<double>(n) * options_.speed / options_.frame_rate_hz;
    if (t_s > end_s) break;
    player_.seek(t_s);
    if (auto shown = show_moment(); !shown) return shown;
    const auto completed = complete_moment(stop);
    if (!completed) return tl::unexpected(completed.error());
    if (!*completed) break;
    if (auto saved = view_.save_png(folder->next()); !saved) return saved;
  }
  print_text("{}\n", folder->describe(options_.frame_rate_hz));
  return {};
}

void RecordedSession::show_carved() {
  if (carved_ != nullptr && carved_->show()) window_.step().reshape_scene();
}

Result<void> RecordedSession::show_moment() {
  const double t_s = player_.moment_s();
  const auto recorded = find_recorded_state(index_, rows_, t_s);
  if (!recorded) return fail("{}: has changed while it was shown; start vision_node again", options_.session.string());
  VisionStep& step = window_.step();
  step.receive(recorded->state, clock_.now_ns());
  step.set_recording(recorded->X_WS, describe_recording(options_.session.filename().string(), player_, recorded->state.sample),
                     notice_.line().empty() ? describe_mark(index_, t_s) : notice_.line());
  if (carves_) carves_->show(t_s);
  if (surfaces_) surfaces_->show(t_s, recorded->state.scene_time_ns);
  if (objects_ && objects_->show(t_s, recorded->state.scene_time_ns)) step.request_redraw();
  if (moved_ != nullptr && moved_->held() != step.held_object()) step.set_held_object(moved_->held());
  if (marks_ != nullptr) marks_->show(recorded->state.scene_time_ns, recorded->X_WS);
  if (const HapticsSetup* setup = index_.find_setup(player_.moment_s())) window_.use_setup(*setup);
  compare_scene();
  return {};
}

void RecordedSession::compare_scene() {
  const std::uint64_t recorded = index_.find_scene_hash(player_.moment_s());
  const bool is_other = recorded != 0 && scene_hash_ != 0 && recorded != scene_hash_;
  if (is_other == is_other_scene_) return;
  is_other_scene_ = is_other;
  window_.step().set_other_scene(is_other);
  if (is_other) log_warning("the recording has another scene than the one shown; name the one of the recording with --scene");
}

void RecordedSession::begin_export() {
  if (marks_ != nullptr) export_.begin({*scene_, marks_->placed_annotations(), marks_->X_SO(), carved_});
}

// newest: empty if there is no new notice. Returns whether the picture gets another line.
bool RecordedSession::show_notice(std::string newest) {
  if (std::string exported = export_.take_notice(); !exported.empty()) newest = std::move(exported);
  const bool is_new = notice_.update(std::move(newest), clock_.now_ns());
  if (is_new) window_.step().request_redraw();
  return is_new;
}

// Returns a line for the picture, or an empty text.
std::string RecordedSession::attend_window() {
  const auto take = [this](const WindowEvent& event) {
    return control_.handle(event, view_.find_picture_pixel(event.x_px, event.y_px), view_.picture_size());
  };
  show_carved();
  const UserRequests requests = window_.poll_events(take, {});
  quit_ = quit_ || requests.quit;
  if (requests.export_work) begin_export();
  if (!requests.screenshot) return {};
  draw();
  return window_.take_numbered_screenshot();
}

bool RecordedSession::wants_picture(std::int64_t now_ns) {
  const VisionStep::Screen where = window_.where();
  if (window_.step().wants_picture(now_ns, where)) return true;
  if (!window_.step().may_draw(now_ns)) return false;
  if (std::abs(moment_share() - drawn_share_) * where.picture.width_px >= 1.0) return true;
  return !player_.is_paused() && now_ns - drawn_ns_ >= kRecordedClockNs;
}

Result<void> RecordedSession::draw_if_wanted() {
  const std::int64_t begin_ns = clock_.now_ns();
  if (!wants_picture(begin_ns)) return {};
  draw();
  const bool keep = !options_.screenshot.empty() && screenshot_moment_.take_now(begin_ns - start_ns_, window_.step().contact());
  return keep ? window_.take_screenshot(options_.screenshot) : Result<void>{};
}

void RecordedSession::draw() {
  const std::int64_t begin_ns = clock_.now_ns();
  VisionStep& step = window_.step();
  VisionStep::Shown shown = step.compose(begin_ns);
  if (step.shows_plots()) shown.plots = make_recorded_plots(index_, player_.moment_s());
  drawn_share_ = moment_share();
  view_.set_time_line(time_line_, drawn_share_);  // first: the other texts are placed above it
  window_.show(shown);
  if (moved_ != nullptr && moved_->has_motion()) moved_->place_moving();
  view_.draw([this, &step] {
    if (const auto newest = step.newest_probe()) view_.set_probe(*newest);
  });
  drawn_ns_ = begin_ns;
  step.end_frame(begin_ns, clock_.now_ns(), window_.where());
  if (step.frames().drawn() == 1) {
    if (const auto age_s = read_process_age_s()) log_info("first frame {:.2f} s after the start", *age_s);
  }
}

}  // namespace hapton
