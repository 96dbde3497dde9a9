#pragma once

#include <numbers>

#include "vision_node/stereo_camera.h"

namespace hapton {

inline constexpr double kSteepestPitch = 89.0 * std::numbers::pi / 180.0;  // up is undefined at 90 degrees

// The viewer's position relative to the initial view: orbited round the workspace, zoomed, panned. The haptic scene does not move. Frame W.
// RT: no. Threads: one.
struct CameraView {
  double yaw_rad = 0.0;       // to the right of the initial view
  double pitch_rad = 0.0;     // above the initial view
  double zoom = 1.0;          // magnification
  Vec3 pan_m = Vec3::Zero();  // displacement of the centre of the picture
  bool is_centred = false;    // look_at() was called: the picture is centred without the initial view's Framing::centre_offset_m

  // Turns by these angles. Angles that are not finite are ignored.
  void orbit(double yaw_by_rad, double pitch_by_rad);
  // Multiplies the zoom by a factor, and keeps it from 0.1 to 100. A factor that is not positive and finite is ignored.
  void zoom_by(double factor);
  // Centres the picture on a sphere and zooms until the sphere nearly fills it. Ignores values that are not valid. home: as in apply().
  void look_at(const Framing& home, const Vec3& p_WO, double radius_m);

  // The framing of this view; home is the initial one. The view is never straight from above or below, where up is undefined. With
  // magnification the distance between the eyes shrinks, so that depth looks the same; if the width of the screen is known, the whole
  // viewer scales instead. If the place of the screen is known (Framing::screen), objects must be drawn where they are felt: the result is
  // home.
  Framing apply(const Framing& home) const;

  friend bool operator==(const CameraView&, const CameraView&) = default;
};

}  // namespace hapton
