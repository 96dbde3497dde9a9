#pragma once

#include <optional>

#include "core/geometry/screen_rectangle.h"
#include "core/math/types.h"

namespace hapton {

using Vec2 = Eigen::Vector2d;
using Mat4 = Eigen::Matrix4d;

enum class Eye { left, right, centre };

// Where the viewer is until told otherwise: people look at a desk display from arm's length. Metres.
constexpr double kDeskDistance = 0.6;
constexpr double kEyeDistance = 0.063;  // metres; mean of adults (Dodgson 2004)

// The viewer's head in front of the screen, in real size. Frames: R, the screen's (origin in its centre, x right, y up, z towards the
// viewer), and H, the head's: origin midway between the eyes, x towards the right eye, y up. Units: metres.
struct Head {
  Vec3 p_RH = Vec3(0.0, 0.0, kDeskDistance);
  Quat q_RH = Quat::Identity();
};

// A window into the world: the picture is the rectangle width_m x height_m in the plane z = 0 of the view frame V, and each eye looks
// through that same rectangle. Points in the plane have no parallax; nearer points appear in front of the screen. Frames: V has its origin
// in the rectangle's centre, x right, y up, z out of the screen towards the viewer. Units: metres of the world. Pre: every length positive
// (ipd_m may be 0: no depth), near_m < far_m, both measured from between the eyes along -z of V. Both eyes are in front of the plane.
struct StereoScreen {
  Pose X_WV = Pose::Identity();
  double width_m = 0.52;
  double height_m = 0.29;
  double distance_m = 0.6;            // from the plane to the middle between the eyes
  Vec2 eyes_offset_m = Vec2::Zero();  // from the rectangle's centre to that middle: right, up
  Vec3 to_right_V = Vec3(1.0, 0, 0);  // from the left eye to the right one, of length 1
  double ipd_m = kEyeDistance;
  double near_m = 0.06;
  double far_m = 6.0;
  Vec3 light_V = Vec3(-0.40, 0.62, 0.85).normalized();  // towards the light: from over the viewer's left shoulder
};

// A picture's size in pixels (one eye's, if two pictures share a window).
struct PictureSize {
  int width_px = 0;
  int height_px = 0;
  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

// What shall be seen, before it is known how large the window is.
struct Framing {
  Vec3 p_WC = Vec3::Zero();             // workspace centre: on the zero-parallax plane, in the middle of the screen if centre_offset_m is 0
  Vec2 centre_offset_m = Vec2::Zero();  // from p_WC to the screen's centre, in the screen's plane: right, up
  double yaw_rad = 0.0;                 // the viewer is turned about p_WC: from the z axis this far to the right ...
  double pitch_rad = 0.0;               // ... and this far up
  double roll_rad = 0.0;                // the screen is turned this far about its z axis, counter-clockwise
  double view_m = 0.3;                  // the picture's smaller side, on the zero-parallax plane
  double distance_m = kDeskDistance;    // from the eyes to the zero-parallax plane, while the head is in its initial position
  double ipd_m = kEyeDistance;          // between the eyes
  double depth_m = 0.5;                 // everything drawn lies within this distance of p_WC
  Head head;
  // Width of the picture on the desk, m; 0: not known. If it is known, the viewer is larger than in reality by the same factor as the
  // picture; of distance_m and ipd_m only the ratio then counts.
  double screen_width_m = 0.0;
  // Where the picture is on the desk, in true size. Its edges are then those of this rectangle, however many pixels it has:
  // centre_offset_m, the angles, view_m and screen_width_m mean nothing, and the viewer is as large as in reality.
  std::optional<ScreenRectangle> screen = {};
};

// How many metres of the world one real metre of the viewer is, in a picture that is width_m wide in the world.
double compute_viewer_scale(const Framing& framing, double width_m);

// Whether both eyes, ipd_m apart, are at least kNearestEyeM in front of the screen, and the head at most kFarthestHeadM away. Real metres.
constexpr double kNearestEyeM = 0.05;
constexpr double kFarthestHeadM = 100.0;
bool is_possible(const Head& head, double ipd_m);

// The framing that shows a whole sphere of radius_m around p_WC. Scenes larger than a desk are seen by a proportionally larger viewer, and
// tiny ones by a smaller one (distance and ipd change alike), so that depth looks the same at every scale.
Framing frame_sphere(const Vec3& p_WC, double radius_m, double ipd_m);

// The screen for a picture of that size: square pixels for every aspect ratio, unless the framing says where the screen is.
StereoScreen compute_screen(const Framing& framing, PictureSize size);

// Eye position in the world, p_WE.
Vec3 compute_eye_position(const StereoScreen& screen, Eye eye);

// Distances from that eye along -z of V: to the plane, and to the nearest and the farthest that is drawn.
struct EyeDepths {
  double eye_m = 0.0;
  double near_m = 0.0;
  double far_m = 0.0;
};
EyeDepths compute_eye_depths(const StereoScreen& screen, Eye eye);

// World to eye coordinates: X_EW; the eye looks along -z, both eyes' axes parallel.
Mat4 compute_view_matrix(const StereoScreen& screen, Eye eye);

// Eye to clip coordinates: the off-axis frustum from the eye through the screen rectangle.
Mat4 compute_projection_matrix(const StereoScreen& screen, Eye eye);

// Where a point of the world is drawn: pixels from the picture's lower left corner (pixel centres at .5). Pre: the point is in front of the
// eye.
Vec2 project_to_pixel(const StereoScreen& screen, Eye eye, PictureSize size, const Vec3& p_W);

// The x, on the screen plane, at which the right eye sees a point z_m in front of that plane, minus that of the left eye: ipd z / (z - d).
// Zero on the plane, negative (crossed) in front of it, at most ipd_m behind it. Pre: the eyes are beside each other (to_right_V is x).
double compute_disparity_m(const StereoScreen& screen, double z_m);

// World displacement, parallel to the screen, that moves a point at depth z_m (V) by that many pixels.
Vec3 displace_in_screen_plane(const StereoScreen& screen, PictureSize size, const Vec2& pixels, double z_m);

}  // namespace hapton
