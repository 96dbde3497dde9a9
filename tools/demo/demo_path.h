#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime/trajectory_csv.h"
#include "scene/scene_file.h"

namespace hapton {

// A path that the simulated hand (devices/hand_script.h) repeats: the positions to which it pulls the stylus, frame W, m, the first row at
// 0 s. A surface stops the stylus; the hand then presses in proportion to the distance of its aim behind the surface. RT: no.
using DemoPath = std::vector<TrajectoryRow>;

// The foremost point of the scene (greatest z) at this x and y, with the scene as its file places it; none: no surface is there.
std::optional<Vec3> find_front(const Scene& scene, double x_m, double y_m);

// Comes to the scene from the front at (x, y), presses and draws small slow circles for hold_s, leaves. Error: no surface is at (x, y).
Result<DemoPath> make_rest_path(const Scene& scene, double x_m, double y_m, double hold_s);

// Presses into the groove (demo_shapes.h) and moves back and forth on a straight line, around which the groove bends.
DemoPath make_groove_path();

// Taps at the wall, from in front of it to behind it, so fast that the hand moves farther between two samples at 1 kHz than the wall is
// thick; in each fourth tap the hand stays behind the wall for a while.
DemoPath make_tap_path();

// Presses and draws arcs over the front of a ball around the origin.
DemoPath make_arc_path(double radius_m);

}  // namespace hapton
