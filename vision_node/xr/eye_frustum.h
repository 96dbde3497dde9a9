#pragma once

#include "core/math/types.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// What an eye of a headset sees: angles between its axis and the four edges of its image, radians, positive to the right and up. They
// need not be symmetric: left_rad and down_rad are usually negative. Source: XrFovf of OpenXR 1.0.
struct FieldOfView {
  double left_rad = -0.8;
  double right_rad = 0.8;
  double up_rad = 0.8;
  double down_rad = -0.8;
};

// Whether the angles make a frustum: edges in order, each less than a right angle from the axis. False for NaN.
bool is_possible(const FieldOfView& fov);

// Pose and field of view of an eye in a frame F. The eye's frame E: origin in the pupil, x right, y up; it looks along -z.
struct EyeInFrame {
  Pose X_FE = Pose::Identity();
  FieldOfView fov;
};

// Distances along the axis of a headset's eye. Metres.
struct HeadsetDepths {
  double plane_m = 0.6;  // image plane: the plane of the rectangle of look_through()
  double near_m = 0.02;  // near clipping plane
  double far_m = 6.0;    // far clipping plane
};

// Distances for a viewer whose eyes are at p_WE. All of the workspace and its surroundings (Framing::p_WC and depth_m) that is at least
// near_m from the eyes is drawn, also when the head is inside. Frame W.
HeadsetDepths find_headset_depths(const Framing& framing, const Vec3& p_WE);

// The rectangle at plane_m before the eye that fills its field of view, as a StereoScreen. For this screen compute_view_matrix gives the
// inverse of X_WE, and compute_projection_matrix the frustum of the field of view, with either value of Eye. light_W: unit vector towards
// the light. Frame W. Pre: is_possible(eye.fov), X_WE is rigid.
StereoScreen look_through(const EyeInFrame& eye_in_W, const HeadsetDepths& depths, const Vec3& light_W);

}  // namespace hapton
