#include "vision_node/xr/headset_show.h"

#include <utility>

#include "runtime/log.h"

namespace hapton {

Pose find_head(const EyeInFrame& left, const EyeInFrame& right) {
  const Quat turned = Quat(left.X_FE.linear()).slerp(0.5, Quat(right.X_FE.linear()));
  return Eigen::Translation3d(0.5 * (left.X_FE.translation() + right.X_FE.translation())) * Pose(turned.normalized());
}

Result<std::unique_ptr<HeadsetShow>> HeadsetShow::open(std::unique_ptr<Headset> headset, StereoView& view, RoomSpace space,
                                                       const Pose& X_OW) {
  if (auto opened = headset->open(view.glx_window(), space); !opened) return tl::unexpected(opened.error());
  const PictureSize size = headset->eye_size();
  log_info("OpenXR runtime {}: {}x{} pixels an eye; the workspace is at {:g}, {:g}, {:g} m in the {} space", headset->name(), size.width_px,
           size.height_px, X_OW.translation().x(), X_OW.translation().y(), X_OW.translation().z(),
           space == RoomSpace::stage ? "stage" : "local");
  return std::unique_ptr<HeadsetShow>(new HeadsetShow(std::move(headset), view, WorkspacePlace(X_OW, space)));
}

HeadsetShow::~HeadsetShow() {
  view_.make_current();
  headset_.reset();
}

bool HeadsetShow::begin_turn(const Framing& framing) {
  if (is_loss_reported_) return false;
  view_.make_current();
  headset_->poll_events();
  const bool is_wanted = headset_->is_running() && headset_->begin_frame();
  if (is_wanted) aim(framing);
  set_shown(is_wanted);
  if (headset_->has_ended()) log_info("the OpenXR runtime has ended the session");
  report_loss();
  return is_wanted;
}

void HeadsetShow::report_loss() {
  if (!headset_->is_lost() || std::exchange(is_loss_reported_, true)) return;
  set_shown(false);
  log_warning("the headset is lost ({}); the window goes on in mono. Start vision_node again once the OpenXR runtime works",
              headset_->loss());
}

void HeadsetShow::aim(const Framing& framing) {
  const Pose X_WL = place_.X_LW().inverse(Eigen::Isometry);
  const auto& [left, right] = headset_->eyes();
  const HeadsetDepths depths = find_headset_depths(framing, X_WL * find_head(left, right).translation());
  const auto look = [&](const EyeInFrame& eye) { return look_through({X_WL * eye.X_FE, eye.fov}, depths, StereoScreen().light_V); };
  view_.set_headset_eyes({headset_->eye_size(), look(left), look(right)});
}

void HeadsetShow::set_shown(bool is_shown) {
  if (std::exchange(is_shown_, is_shown) == is_shown) return;
  if (is_shown) {
    log_info("the headset shows the scene");
  } else if (!headset_->is_lost() && !headset_->has_ended()) {
    log_info("the headset does not show the scene at present; the window goes on in mono");
  }
  // No error is possible: both modes work on every display.
  static_cast<void>(view_.set_stereo(is_shown ? StereoMode::openxr : StereoMode::mono));
}

void HeadsetShow::show() {
  view_.make_current();
  headset_->end_frame([this](std::size_t eye, unsigned texture) { view_.copy_eye(eye, texture); });
  view_.show_mirror();
  report_loss();
}

void HeadsetShow::recentre() { place_.recentre(find_head(headset_->eyes()[0], headset_->eyes()[1])); }

}  // namespace hapton
