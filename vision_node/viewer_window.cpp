#include "vision_node/viewer_window.h"

#include <numbers>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "runtime/log.h"
#include "vision_node/screen_aspect.h"
#include "vision_node/teach_figure.h"

namespace hapton {
namespace {

VisionStepSettings make_step_settings(const StereoView& view, const VisionOptions& options) {
  VisionStepSettings settings;
  for (int axis = 0; axis < 3; ++axis) settings.dials.turn(axis, options.dials_degrees[axis]);
  settings.stylus_lean = make_lean(options.stylus_lean_deg * std::numbers::pi / 180.0);
  settings.max_rate_hz = options.rate_limit_hz;
  settings.always_changing = view.mode() == StereoMode::emulate;
  settings.cull = options.view.cull;
  settings.depth_cues = options.view.depth_cues;
  settings.help = options.help;
  settings.stereo = stereo_mode_name(view.mode());
  settings.home = options.view.framing;
  settings.p_SO = options.p_SO;
  settings.scene_radius_m = options.scene_radius_m;
  settings.names = options.names;
  settings.plots = options.plots;
  settings.head = options.head;
  settings.ipd_m = 1e-3 * options.ipd_mm;
  return settings;
}

// The modes that the key m cycles through: an ordinary screen, two pictures, coloured glasses.
StereoMode next_stereo(StereoMode mode) {
  switch (mode) {
    case StereoMode::mono:
      return StereoMode::side_by_side;
    case StereoMode::side_by_side:
      return StereoMode::anaglyph;
    default:
      return StereoMode::mono;
  }
}

}  // namespace

ViewerWindow::ViewerWindow(StereoView& view, Clock& clock, const VisionOptions& options)
    : view_(view), clock_(clock), options_(options), step_(make_step_settings(view, options)), teach_choice_(options.teach) {
  if (options.probe_radius_m > 0.0) view_.set_probe_radius(options.probe_radius_m);
}

UserRequests ViewerWindow::poll_events(const TakeEvent& take, const FindSurface& find_surface) {
  handle_events(take, find_surface);
  follow_head();
  if (view_.take_redraw_request()) step_.request_redraw();
  check_aspect();
  const UserRequests requests = step_.take_requests();
  change_stereo(requests);
  choose_teach(requests);
  update_teaching();
  step_.set_detail_progress(view_.detail_progress());
  return requests;
}

void ViewerWindow::use_setup(const HapticsSetup& setup) {
  set_size_ = find_set_size(setup.method.data());
  if (options_.probe_radius_m >= 0.0) return;
  const double radius_m = find_probe_radius(setup.method.data());
  if (radius_m == probe_radius_m_) return;
  probe_radius_m_ = radius_m;
  view_.set_probe_radius(radius_m);
  step_.request_redraw();
}

void ViewerWindow::change_scene(TeachBuilder* teacher, bool is_view_new) {
  teacher_ = teacher;
  requested_choice_ = {};
  if (teach_choice_.view != TeachView::off) view_.teach_figure().hide();
  step_.change_scene(options_.view.framing, options_.p_SO, options_.scene_radius_m, options_.names, is_view_new);
}

void ViewerWindow::choose_teach(const UserRequests& requests) {
  if (teacher_ == nullptr) return;
  const TeachChoice before = teach_choice_;
  if (requests.next_teach) teach_choice_ = next_teach(teach_choice_);
  if (requests.next_level) teach_choice_ = next_level(teach_choice_, teacher_->tree_depth());
  if (teach_choice_ == before) return;  // the tree has only one level: there would be nothing new to request
  view_.teach_figure().hide();
  step_.set_teaching(teach_choice_.view == TeachView::off ? std::string()
                                                          : std::string(teach_name(teach_choice_.view)) + ": being prepared");
}

std::optional<TeachProbe> ViewerWindow::find_teach_probe() const {
  const auto shown = step_.newest_probe();
  if (!shown) return std::nullopt;
  const Pose X_SW = step_.scene_pose().inverse(Eigen::Isometry);
  TeachProbe probe{.p_SP = X_SW * shown->p_WP, .p_SD = X_SW * shown->p_WD, .force_S_n = X_SW.linear() * shown->force_n};
  probe.is_contact = shown->contact;
  probe.radius_m = options_.probe_radius_m >= 0.0 ? options_.probe_radius_m : probe_radius_m_;
  probe.set_size = set_size_;
  return probe;
}

// Views of the whole scene follow the probe in strides, because they are large.
bool ViewerWindow::wants_teach(const TeachProbe& probe) const {
  constexpr double kStrideShare = 0.05;  // of the scene's radius (decision 163)
  if (teach_choice_ != requested_choice_) return true;
  const bool is_large =
      teach_choice_.view == TeachView::tree || teach_choice_.view == TeachView::grid || teach_choice_.view == TeachView::curvature;
  const double moved_m = (probe.p_SP - requested_probe_.p_SP).norm();
  if (is_large) return moved_m > kStrideShare * options_.scene_radius_m;
  return moved_m > 0.0 || probe.p_SD != requested_probe_.p_SD || probe.is_contact != requested_probe_.is_contact;
}

void ViewerWindow::update_teaching() {
  if (teacher_ == nullptr) return;
  const auto made = teacher_->take_shapes();
  if (made && made->choice == teach_choice_) {
    view_.teach_figure().set(*made);
    step_.set_teaching(made->caption);
  }
  if (teach_choice_.view == TeachView::off || teacher_->is_busy()) return;
  const TeachProbe probe = find_teach_probe().value_or(TeachProbe());
  if (!wants_teach(probe)) return;
  requested_choice_ = teach_choice_;
  requested_probe_ = probe;
  teacher_->request(teach_choice_, probe);
}

void ViewerWindow::finish_teaching(const StopSignal& stop) {
  if (teacher_ == nullptr || teach_choice_.view == TeachView::off) return;
  update_teaching();
  constexpr std::int64_t kPauseNs = 5 * kNanosecondsPerMillisecond;  // between two checks of the other thread; a free choice
  while (teacher_->is_busy() && !stop.stop_requested()) clock_.sleep_until_ns(clock_.now_ns() + kPauseNs);
  update_teaching();
}

void ViewerWindow::show(const VisionStep::Shown& shown) {
  view_.set_scene_pose(shown.X_WS);
  view_.set_framing(shown.framing);
  view_.set_cull(shown.cull);
  view_.set_depth_cues(shown.depth_cues);
  view_.set_hud(shown.hud, shown.help, shown.notice);
  view_.set_plots(shown.plots);
}

// Checks the shape of the picture against --screen after each resize. Not in side_by_side: only some displays stretch the halves.
void ViewerWindow::check_aspect() {
  if (!options_.screen || view_.mode() == StereoMode::side_by_side) return;
  PictureSize size = view_.picture_size();
  if (view_.mode() == StereoMode::top_bottom) size.height_px *= 2;
  if (std::exchange(checked_size_, size) == size) return;
  const std::string line = describe_aspect(*options_.screen, size);
  if (!line.empty() && !is_aspect_wrong_) log_warning("{}", line);
  is_aspect_wrong_ = !line.empty();
}

void ViewerWindow::follow_head() {
  const std::int64_t now_ns = clock_.now_ns();
  if (space_head_ != nullptr) step_.move_head(space_head_->take_move_m(now_ns));
  if (head_tracker_ == nullptr) return;
  if (const auto head = head_tracker_->take_head(now_ns)) step_.set_head(*head);
  step_.set_head_notice(head_tracker_->describe(now_ns));
}

// Of consecutive motions of the mouse, only the last one is handled.
void ViewerWindow::handle_events(const TakeEvent& take, const FindSurface& find_surface) {
  const std::vector<WindowEvent> events = view_.poll_events();
  for (std::size_t i = 0; i < events.size(); ++i) {
    const WindowEvent& event = events[i];
    const bool is_move = event.kind == WindowEvent::Kind::move;
    if (is_move && i + 1 < events.size() && events[i + 1].kind == WindowEvent::Kind::move) continue;
    if (take && take(event)) continue;
    step_.handle(event, where(), find_surface && step_.wants_surface(event) ? find_surface(event) : std::nullopt);
  }
}

void ViewerWindow::change_stereo(const UserRequests& requests) {
  if (view_.mode() == StereoMode::openxr) return;  // the eyes are those of the headset
  if (requests.swap_eyes) {
    view_.swap_eyes();
    step_.request_redraw();
  }
  if (!requests.next_stereo) return;
  if (const auto changed = view_.set_stereo(next_stereo(view_.mode())); !changed) log_warning("{}", changed.error().what);
  step_.set_stereo(stereo_mode_name(view_.mode()), view_.mode() == StereoMode::emulate);
}

void ViewerWindow::refine_scene() {
  if (step_.is_scene_at_rest(clock_.now_ns()) && view_.refine()) step_.request_redraw();
}

Result<void> ViewerWindow::take_screenshot(const std::filesystem::path& file) {
  // The texts in the window may be older than the probe and the force bar in it.
  const VisionStep::Texts texts = step_.compose_texts(clock_.now_ns());
  view_.set_hud(texts.hud, texts.help, texts.notice);
  if (auto saved = view_.save_png(file); !saved) return saved;
  log_info("screenshot written to {}", file.string());
  return {};
}

std::string ViewerWindow::take_numbered_screenshot() {
  std::filesystem::path name;
  std::error_code ignored;
  do name = fmt::format("hapton_{:03}.png", ++screenshots_);
  while (std::filesystem::exists(name, ignored));
  const auto saved = take_screenshot(name);
  if (saved) return {};
  --screenshots_;  // the next one may take the number
  log_warning("{}", saved.error().what);
  return "NO SCREENSHOT: " + saved.error().what;
}

}  // namespace hapton
