#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "vision_node/stereo_camera.h"

namespace hapton {

// What makes depth readable without a second eye, as lines in the world. Frame W, metres.
using LineSegment = std::array<Vec3, 2>;

// The workspace of the memo's device around the workspace centre: 10.5 x 7.5 x 15 inches (docs/frames.md).
inline Vec3 workspace_size_m() { return {0.2667, 0.1905, 0.381}; }

// The twelve edges of the workspace.
std::vector<LineSegment> make_workspace_box();
// Its corner nearest to a point.
Vec3 find_nearest_corner(const Vec3& p_W);
// Squares of 20 mm on the floor of the workspace.
std::vector<LineSegment> make_ground_grid();
// Height of that floor.
double ground_height_m();

// Moves each point of the world along the light's rays onto the ground: homogeneous, 4 x 4. towards_light points from the ground up.
Mat4 compute_shadow_matrix(const Vec3& towards_light);
// Where a point's shadow lies; none for one below the ground.
std::optional<Vec3> find_shadow(const Vec3& p_W);
// Where the light comes from that throws the shadows: from above, a little from the left and from the front.
Vec3 shadow_light();

// A length that is easy to read, 1, 2 or 5 times a power of ten, and its size in the plane of the screen.
struct ScaleBar {
  double length_m = 0.0;
  double pixels = 0.0;
  std::string label;
};
// The longest that is at most a fifth of the picture's width.
ScaleBar choose_scale_bar(const StereoScreen& screen, PictureSize size);

}  // namespace hapton
