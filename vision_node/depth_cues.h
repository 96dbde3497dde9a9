#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "vision_node/stereo_camera.h"

namespace hapton {

// Lines in the world that make depth readable without a second eye. Frame W, metres.
using LineSegment = std::array<Vec3, 2>;

// Size of the workspace of the memo's device, which is centred at the workspace centre: 10.5 x 7.5 x 15 inches (docs/frames.md).
inline Vec3 workspace_size_m() { return {0.2667, 0.1905, 0.381}; }

// The twelve edges of the workspace.
std::vector<LineSegment> make_workspace_box();
// The corner of the workspace nearest to a point.
Vec3 find_nearest_corner(const Vec3& p_W);
// Squares of 20 mm on the floor of the workspace.
std::vector<LineSegment> make_ground_grid();
// The height of that floor: its y in W.
double ground_height_m();

// Moves each point of the world along the light's rays onto the ground: homogeneous, 4 x 4. Pre: towards_light, from the ground, has y > 0.
Mat4 compute_shadow_matrix(const Vec3& towards_light);
// Where a point's shadow lies; none for a point that is below the ground or not finite.
std::optional<Vec3> find_shadow(const Vec3& p_W);
// The unit direction to the light that casts the shadows: from above, a little from the left and from the front.
Vec3 direction_to_shadow_light();

// A length that is easy to read (1, 2 or 5 times a power of ten), its size in the plane of the screen, and its text.
struct ScaleBar {
  double length_m = 0.0;
  double pixels = 0.0;
  std::string label;
};
// The longest such length that is at most a fifth of the picture's width; length 0 if the picture has no size.
ScaleBar choose_scale_bar(const StereoScreen& screen, PictureSize size);

}  // namespace hapton
