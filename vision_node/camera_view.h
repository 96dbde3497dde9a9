#pragma once

#include "vision_node/stereo_camera.h"

namespace hapton {

// The viewer's position relative to the initial view: orbited round the workspace, zoomed, panned. The haptic scene does not move. Frame W.
// RT: no.
struct CameraView {
  double yaw_rad = 0.0;       // further to the right
  double pitch_rad = 0.0;     // further above
  double zoom = 1.0;          // magnification
  Vec3 pan_m = Vec3::Zero();  // of the centre of the picture
  bool is_centred = false;    // the object is in the middle of the picture, whatever the initial view

  void orbit(double yaw_by_rad, double pitch_by_rad);
  // Times the factor, from a tenth to a hundred times. A factor that is not positive and finite is ignored.
  void zoom_by(double factor);
  // Centres the picture on a sphere that then fills it.
  void look_at(const Framing& home, const Vec3& p_WO, double radius_m);

  // The framing of this view; home is the initial one. The view is never straight from above or below, where up is undefined. The eyes come
  // nearer to each other as the picture is magnified, so that depth looks the same; the whole viewer does where the screen's width is
  // known. Where it is known where the screen is, what is drawn must stay where it is felt: home itself.
  Framing apply(const Framing& home) const;

  friend bool operator==(const CameraView&, const CameraView&) = default;
};

}  // namespace hapton
