#pragma once

#include "core/math/types.h"
#include "vision_node/stereo_camera.h"

namespace hapton {

// What an eye of a headset sees: angles between its axis and the four edges of its image, radians, positive to the right and up. They
// need not be symmetric: left_rad and down_rad are negative as a rule. Source: XrFovf of OpenXR 1.0.
struct FieldOfView {
  double left_rad = -0.8;
  double right_rad = 0.8;
  double up_rad = 0.8;
  double down_rad = -0.8;
};

// Whether there is a image: edges in order, less than a right angle from the axis. False for NaN.
bool is_possible(const FieldOfView& fov);

// An eye in a frame F. The eye's frame E: origin in the pupil, x right, y up, it looks along -z.
struct EyeInFrame {
  Pose X_FE = Pose::Identity();
  FieldOfView fov;
};

// From which distance to which a headset's eye sees, along its axis, and where its image is thought to be. Metres.
struct HeadsetDepths {
  double plane_m = 0.6;
  double near_m = 0.02;
  double far_m = 6.0;
};

// For a viewer whose eyes are at p_WE, so that everything round the workspace is seen (Framing::p_WC and depth_m), however near it is.
HeadsetDepths find_headset_depths(const Framing& framing, const Vec3& p_WE);

// The rectangle plane_m before the eye through which it sees with that field of view. All that is drawn through a StereoScreen is then
// drawn for the headset: compute_view_matrix is the inverse of X_WE, compute_projection_matrix the frustum of the tangents. The same for
// each Eye. Frame W. Pre: is_possible(eye.fov), X_WE rigid. light_W: towards the light, of length 1.
StereoScreen look_through(const EyeInFrame& eye_in_W, const HeadsetDepths& depths, const Vec3& light_W);

}  // namespace hapton
