#include "vision_node/camera_view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace hapton {
namespace {

constexpr double kMinZoom = 0.1;  // relative to the zoom of the first view; this and the next: free choices
constexpr double kMaxZoom = 100.0;
// look_at() leaves a margin of a tenth of the radius around the object.
constexpr double kMargin = 1.1;

}  // namespace

void CameraView::orbit(double yaw_by_rad, double pitch_by_rad) {
  if (!std::isfinite(yaw_by_rad) || !std::isfinite(pitch_by_rad)) return;
  yaw_rad = std::remainder(yaw_rad + yaw_by_rad, 2.0 * std::numbers::pi);
  // The limit is twice the steepest pitch, so that every pitch can be reached from every initial view.
  pitch_rad = std::clamp(pitch_rad + pitch_by_rad, -2.0 * kSteepestPitch, 2.0 * kSteepestPitch);
}

void CameraView::zoom_by(double factor) {
  if (!(factor > 0.0) || !std::isfinite(factor)) return;
  zoom = std::clamp(zoom * factor, kMinZoom, kMaxZoom);
}

void CameraView::look_at(const Framing& home, const Vec3& p_WO, double radius_m) {
  if (!(radius_m > 0.0) || !p_WO.allFinite()) return;
  pan_m = p_WO - home.p_WC;
  is_centred = true;
  zoom = std::clamp(home.view_m / (2.0 * kMargin * radius_m), kMinZoom, kMaxZoom);
}

Framing CameraView::apply(const Framing& home) const {
  if (home.screen) return home;
  Framing framing = home;
  framing.p_WC += pan_m;
  framing.yaw_rad += yaw_rad;
  framing.pitch_rad = std::clamp(home.pitch_rad + pitch_rad, -kSteepestPitch, kSteepestPitch);
  framing.view_m /= zoom;
  framing.centre_offset_m = is_centred ? Vec2(0.0, 0.0) : Vec2(home.centre_offset_m / zoom);
  // If the screen's width is known, compute_screen() scales the whole viewer with the picture, including the distance of the eyes.
  if (!(home.screen_width_m > 0.0)) framing.ipd_m /= std::max(1.0, zoom);
  framing.depth_m += pan_m.norm();
  return framing;
}

}  // namespace hapton
