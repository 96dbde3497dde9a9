#pragma once

#include "core/math/types.h"

namespace hapton {

using Vec2 = Eigen::Vector2d;
using Mat4 = Eigen::Matrix4d;

enum class Eye { left, right, centre };

// A window into the world: the picture is the rectangle width_m x height_m in the plane z = 0 of the view frame V, and each eye looks
// through that same rectangle. Points in the plane have no parallax; nearer points appear in front of the screen. Frames: V has its origin
// in the rectangle's centre, x right, y up, z out of the screen towards the viewer. Units: metres. Pre: every length positive (ipd_m may be
// 0: no depth), near_m < far_m; both are measured from the eye along -z of V.
struct StereoScreen {
  Pose X_WV = Pose::Identity();
  double width_m = 0.52;
  double height_m = 0.29;
  double distance_m = 0.6;
  double ipd_m = 0.063;
  double near_m = 0.06;
  double far_m = 6.0;
};

// A picture's size in pixels (one eye's, if two pictures share a window).
struct PictureSize {
  int width_px = 0;
  int height_px = 0;
  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

// What shall be seen, before it is known how large the window is.
struct Framing {
  Vec3 p_WC = Vec3::Zero();     // workspace centre: on the zero-parallax plane, in the middle of the screen but for aside_m
  Vec2 aside_m = Vec2::Zero();  // of the screen's centre from there, in the screen's plane: right, up
  double yaw_rad = 0.0;         // the viewer is this far to the right ...
  double pitch_rad = 0.0;       // ... and this far above the centre's z axis
  double view_m = 0.3;          // the picture's smaller side, on the zero-parallax plane
  double distance_m = 0.6;      // from the eyes to the zero-parallax plane
  double ipd_m = 0.063;         // between the eyes: mean of adults (Dodgson 2004)
  double depth_m = 0.5;         // everything drawn lies within this distance of p_WC
};

// The framing that shows a whole sphere of radius_m around p_WC. Scenes larger than a desk are seen by a proportionally larger viewer
// (distance and ipd grow alike), so that depth looks the same at every scale.
Framing frame_sphere(const Vec3& p_WC, double radius_m, double ipd_m);

// The screen for a picture of that size: square pixels for every aspect ratio.
StereoScreen compute_screen(const Framing& framing, PictureSize size);

// Eye position in the world, p_WE.
Vec3 compute_eye_position(const StereoScreen& screen, Eye eye);

// World to eye coordinates: X_EW; the eye looks along -z, both eyes' axes parallel.
Mat4 compute_view_matrix(const StereoScreen& screen, Eye eye);

// Eye to clip coordinates: the off-axis frustum from the eye through the screen rectangle.
Mat4 compute_projection_matrix(const StereoScreen& screen, Eye eye);

// Where a point of the world is drawn: pixels from the picture's lower left corner (pixel centres at .5). Pre: the point is in front of the
// eye.
Vec2 project_to_pixel(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W);

// Right eye's picture minus left eye's, on the screen plane, of a point z_m in front of that plane: ipd z / (z - d). Zero on the plane,
// negative (crossed) in front of it, at most ipd_m behind it.
double compute_disparity_m(const StereoScreen& screen, double z_m);

// World displacement, parallel to the screen, that moves a point at depth z_m (V) by that many pixels.
Vec3 displace_in_screen_plane(const StereoScreen& screen, PictureSize size, const Vec2& pixels, double z_m);

}  // namespace hapton
